/** What a step decided at a quantity where gradients met. */
export interface Decision {
  /** The gradients that met, a row each. */
  gradients: number[][];
  /** The rank of each: 0 for the leader, -1 where it was not used. */
  ranks: number[];
  /** Index of the gradient that the leader was compared with; -1 for none. */
  opponent: number;
  /** Cosine between the two; 1 where there is none. */
  cosine: number;
  /** Whether the quantity moves in a nullspace instead of downhill. */
  exploring: boolean;
}

/** A named tensor in the readings, the memory or the commands. */
export interface Entry {
  name: string;
  shape: number[];
  kind: "real" | "int" | "bool";
}

/** What a file says of itself. */
export interface Metadata {
  format: number;
  aicon_torch: string;
  description: Record<string, string>;
  dtype: "float64" | "float32";
  /** Time step, s. */
  dt: number;
  /** Gradients in a step. */
  iterations: number;
  sensors: Array<{ name: string; size: number; unit: string; key: string | null; optional: boolean; age: number }>;
  actuators: Array<{ name: string; size: number; unit: string; key: string | null }>;
  goals: string[];
  readings: Entry[];
  memory: Entry[];
  commands: Entry[];
  fingerprint: string;
}

/** A policy that aicon-torch exported to WebAssembly. */
export class Policy {
  private constructor(exports: WebAssembly.Exports);

  /**
   * Load a file, and check that it is whole and computes here what it did when it was exported.
   *
   * @param source An address, a path in Node.js, or what is in the file.
   */
  static load(source: string | URL | ArrayBuffer | ArrayBufferView): Promise<Policy>;

  /** The next step is the first of an episode. Goals that were switched stay as they are. */
  reset(): void;

  /** Whether the episode has yet to begin, as a reading that it begins with has not come. */
  readonly begins: boolean;

  /**
   * One control step.
   *
   * @param readings Those of all sensors one after the other, in the order of `metadata.readings`,
   *   NaN where there is none.
   * @returns The commands, which the next step overwrites.
   */
  step(readings: ArrayLike<number>): Float64Array | Float32Array;

  /** Number of readings. */
  readonly readings: number;
  /** Number of commands. */
  readonly commands: number;
  readonly metadata: Metadata;
  /** What lives from step to step: a copy of it is the moment, and `memory.set(copy)` brings it back. */
  readonly memory: Float64Array | Float32Array;
  /** The quantities where gradients meet. */
  readonly meetings: string[];

  /** The numbers of one entry of `metadata.memory`, which may be written. */
  values(name: string): Float64Array | Float32Array;

  /** What the last step decided at a quantity of `meetings`. */
  decided(quantity: string): Decision;
}

"""Functions of real numbers in C: series, and the reduction of arguments to where they converge.

Sums, products, quotients, square roots and remainders are rounded alike on every processor (IEEE
754). Sines and exponentials are not: each C library has its own, and some have others for
processors that multiply and add at once. With these functions a policy computes the same
everywhere, to the last bit.

They are computed in double precision, to three units in its last place; ``error_function`` to
fifteen; ``power`` to one for each unit of |y ln x| besides. Angles beyond 2²⁰ are good to
|x| 4e-17.
"""

from decimal import Decimal, localcontext

TURNS = 128
"""How many tabulated powers of two there are from 1 to 2."""


def _powers() -> str:
    """2^(i/128), each as the double next to it and what is left of it, as a share, in C."""
    with localcontext(prec=50):
        # Fifty digits: what a double leaves of a power is known to a double's precision itself.
        exact = [Decimal(2) ** (Decimal(i) / TURNS) for i in range(TURNS)]
        pairs = [(float(power), float(power / Decimal(float(power)) - 1)) for power in exact]
    return ",\n".join(f"      {{{whole.hex()}, {rest.hex()}}}" for whole, rest in pairs)


FUNCTIONS = """\
/* c[0] + c[1] x + c[2] x^2 + ..., even and odd powers by themselves; n is even. */
static inline double series(const double *c, int n, double x) {
  double square = x * x, even = c[n - 2], odd = c[n - 1];
  for (int i = n - 4; i >= 0; i -= 2) {
    even = even * square + c[i];
    odd = odd * square + c[i + 1];
  }
  return even + odd * x;
}

/* x 2^n for -1022 <= n <= 1023. */
static inline double scaled(double x, int n) {
  union { unsigned long long bits; double value; } power;
  power.bits = (unsigned long long)(1023 + n) << 52;
  return x * power.value;
}

/* n of 2^n <= |x| < 2^(n + 1), for x that is finite and not 0. */
static inline int exponent_of(double x) {
  union { double value; unsigned long long bits; } parts = {x};
  if (fabs(x) >= 0x1p-1022) return (int)(parts.bits >> 52 & 0x7FF) - 1023;
  parts.value = x * 0x1p54;
  return (int)(parts.bits >> 52 & 0x7FF) - 1023 - 54;
}

/* x - y trunc(x / y), exact: the largest 2^n y goes off until less than y is left. */
static double rest_of(double x, double y) {
  if (!(fabs(x) < INFINITY) || y == 0 || y != y) return NAN;
  double rest = fabs(x), least = fabs(y);
  while (rest >= least) {
    int n = exponent_of(rest) - exponent_of(least), third = n / 3;
    double part = scaled(scaled(scaled(least, third), third), n - 2 * third);
    rest -= part > rest ? 0.5 * part : part;
  }
  return copysign(rest, x);
}

/* The integer next to x, the even one of two, for |x| < 2^51. */
static inline double nearest(double x) { return (x + 0x1.8p52) - 0x1.8p52; }

/* The same for any x, and the integers below, above, and towards zero. */
static inline double rounded(double x) {
  return fabs(x) < 0x1p52 ? copysign((fabs(x) + 0x1p52) - 0x1p52, x) : x;
}
static inline double rounded_down(double x) {
  double next = rounded(x);
  return next > x ? next - 1 : next;
}
static inline double rounded_up(double x) { return -rounded_down(-x); }
static inline double whole_part(double x) { return x < 0 ? rounded_up(x) : rounded_down(x); }

/* exp(x + rest) - 1 for |x| <= ln(2) / 2 and a rest beyond its last place. */
static inline double growth(double x, double rest) {
  static const double c[] = {
      1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880,
      1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
  return x + (x * x * series(c, 12, x) + rest);
}

/* exp(x) = 2^n 2^(i/128) exp(r) for x = (n + i/128) ln 2 + r, with 2^(i/128) from a table. */
static double exponential(double x) {
  static const double powers[][2] = {
POWERS};
  if (!(x < 709.8)) return x != x ? x : INFINITY;
  if (x < -745.2) return 0;

  /* 128 n + i is the end of this number's bits; times the first part of ln(2) / 128 it is exact. */
  union { double value; unsigned long long bits; } whole = {x * 184.6649652337873 + 0x1.8p52};
  double parts = whole.value - 0x1.8p52;
  double r = (x - parts * 0x1.62e42fef00000p-8) - parts * 0x1.473de6af278edp-41;

  /* exp(r) - 1 for |r| <= ln(2) / 256. */
  const double *power = powers[whole.bits & 127];
  double z = r * r, curved = z * (0.5 + r * (1.0 / 6)) + z * z * (1.0 / 24 + r * (1.0 / 120));
  double grown = curved + (r + power[1]);

  if (fabs(x) < 708) {
    union { double value; unsigned long long bits; } scale = {power[0]};
    scale.bits += (whole.bits & ~127ull) << 45;
    return scale.value + scale.value * grown;
  }
  int n = (int)parts >> 7;
  return scaled(scaled(power[0] + power[0] * grown, n / 2), n - n / 2);
}

static double exponential_less_one(double x) {
  if (fabs(x) < 0.34) return x == 0 ? x : growth(x, 0);
  return exponential(x) - 1;
}

/* log(2^n m) = n ln 2 + log(m), with log(m) = 2 artanh(s) for s = (m - 1) / (m + 1). */
static double logarithm(double x) {
  static const double c[] = {2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,  2.0 / 11, 2.0 / 13,
                             2.0 / 15, 2.0 / 17, 2.0 / 19, 2.0 / 21, 2.0 / 23, 2.0 / 25};
  if (!(x > 0)) return x == 0 ? -INFINITY : NAN;
  if (x == INFINITY) return x;

  int n = exponent_of(x), half_n = n / 2;
  double m = scaled(scaled(x, -half_n), half_n - n);
  if (m > 1.4142135623730951) m *= 0.5, ++n;

  double above = m - 1, s = above / (2 + above), z = s * s, half = 0.5 * above * above;
  double small = s * (half + z * series(c, 12, z)) + n * -4.2009150726810846e-11;
  return n * 0.6931471806019545 + (above - (half - small));
}

static double logarithm_of_one_more(double x) {
  double more = 1 + x;
  if (more == 0) return -INFINITY;
  if (more == 1 || !(more < INFINITY)) return x;
  return logarithm(more) - ((more - 1) - x) / more;
}

/* x^y: products for small whole y, else exp(y log |x|), with the sign of x where y is odd. */
static double power(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (x != x || y != y) return x + y;

  int is_whole = fabs(y) >= 0x1p53 || rest_of(y, 1) == 0;
  if (is_whole && fabs(y) <= 64) {
    double base = y < 0 ? 1 / x : x, product = 1;
    for (int n = (int)fabs(y); n > 0; n /= 2, base *= base)
      if (n % 2 == 1) product *= base;
    return product;
  }
  if (x < 0 && x != -INFINITY && !is_whole) return NAN;
  double value = fabs(x) == 1 ? 1 : exponential(y * logarithm(fabs(x)));
  return is_whole && rest_of(y, 2) != 0 && fabs(y) != INFINITY ? copysign(value, x) : value;
}

/* x = n pi/2 + angle + rest with |angle| <= pi/4; beyond 2^20 an angle is as good as its remainder
   by the number next to 2 pi. Returns n modulo 4. */
static inline int quadrant(double x, double *angle, double *rest) {
  if (!(fabs(x) < 0x1p20)) x = rest_of(x, 6.283185307179586);
  double n = nearest(x * 0.6366197723675814);

  /* n times each of the first two parts of pi/2 is exact. */
  double first = x - n * 1.5707963267341256, second = n * 6.077100506303966e-11;
  double part = first - second, back = part - first;
  *angle = part;
  *rest = (first - (part - back)) - (second + back) - n * 2.0222662487959506e-21;
  return (int)(long long)(n != n ? 0 : n) & 3;
}

static inline double sine_within(double x, double rest) {
  static const double c[] = {-1.0 / 6,        1.0 / 120,          -1.0 / 5040,
                             1.0 / 362880,    -1.0 / 39916800,    1.0 / 6227020800,
                             -1.0 / 1307674368000, 1.0 / 355687428096000};
  double z = x * x;
  return x + (x * z * series(c, 8, z) + rest * (1 - 0.5 * z));
}

static inline double cosine_within(double x, double rest) {
  static const double c[] = {1.0 / 24,         -1.0 / 720,           1.0 / 40320,
                             -1.0 / 3628800,   1.0 / 479001600,      -1.0 / 87178291200,
                             1.0 / 20922789888000, -1.0 / 6402373705728000};
  double z = x * x, half = 0.5 * z, most = 1 - half;
  return most + (((1 - most) - half) + (z * z * series(c, 8, z) - x * rest));
}

static double sine(double x) {
  if (x == 0) return x;
  double angle, rest;
  int n = quadrant(x, &angle, &rest);
  double value = n & 1 ? cosine_within(angle, rest) : sine_within(angle, rest);
  return n & 2 ? -value : value;
}

static double cosine(double x) {
  double angle, rest;
  int n = quadrant(x, &angle, &rest);
  double value = n & 1 ? sine_within(angle, rest) : cosine_within(angle, rest);
  return (n + 1) & 2 ? -value : value;
}

static double tangent(double x) { return sine(x) / cosine(x); }

/* atan(x) = atan(k/4) + atan((x - k/4) / (1 + x k/4)) for 0 <= x <= 1. */
static inline double angle_within(double x) {
  static const double turned[] = {0.0, 0.24497866312686414, 0.4636476090008061,
                                  0.6435011087932844, 0.7853981633974483};
  static const double c[] = {-1.0 / 3,  1.0 / 5,  -1.0 / 7,  1.0 / 9,
                             -1.0 / 11, 1.0 / 13, -1.0 / 15, 1.0 / 17};
  int k = (int)(4 * x + 0.5);
  double rest = (x - 0.25 * k) / (1 + x * (0.25 * k)), z = rest * rest;
  return turned[k] + (rest + rest * z * series(c, 8, z));
}

/* The angle of (x, y), in (-pi, pi]. */
static double angle_of(double y, double x) {
  if (x != x || y != y) return x + y;
  double across = fabs(x), up = fabs(y), angle = 0;
  if (up == across)
    angle = up == 0 ? 0 : 0.7853981633974483;
  else if (up < across)
    angle = angle_within(up / across);
  else
    angle = 1.5707963267948966 - (angle_within(across / up) - 6.123233995736766e-17);

  if (signbit(x)) angle = 3.141592653589793 - (angle - 1.2246467991473532e-16);
  return copysign(angle, y);
}

static double arc_tangent(double x) { return angle_of(x, 1); }
static double arc_sine(double x) { return angle_of(x, sqrt((1 - x) * (1 + x))); }
static double arc_cosine(double x) { return angle_of(sqrt((1 - x) * (1 + x)), x); }

/* The length of (x, y), where their squares may be too large or too small. */
static double length_of(double x, double y) {
  double most = fabs(x), least = fabs(y);
  if (most < least) most = fabs(y), least = fabs(x);
  if (most == INFINITY || least == INFINITY) return INFINITY;
  if (least == 0) return most;
  double ratio = least / most;
  return most * sqrt(1 + ratio * ratio);
}

static double hyperbolic_sine(double x) {
  double size = fabs(x), half = exponential(0.5 * size), less = exponential_less_one(size);
  double value = size > 700 ? 0.5 * half * half : 0.5 * (less + less / (less + 1));
  return copysign(value, x);
}

static double hyperbolic_cosine(double x) {
  double half = exponential(0.5 * fabs(x));
  return 0.5 * half * half + 0.5 / half / half;
}

static double hyperbolic_tangent(double x) {
  double less = exponential_less_one(2 * fabs(x));
  return copysign(fabs(x) > 20 ? 1 : less / (less + 2), x);
}

/* erf(x) = 2/sqrt(pi) exp(-x^2) times the sum of x (2 x^2)^n / (1 3 5 ... (2n + 1)). */
static double error_function(double x) {
  if (x != x) return x;
  if (fabs(x) > 6) return copysign(1, x);
  double z = x * x, term = x, sum = x;
  for (int n = 1; fabs(term) > 1e-17 * fabs(sum); ++n) {
    term *= 2 * z / (2 * n + 1);
    sum += term;
  }
  return 1.1283791670955126 * exponential(-z) * sum;
}
""".replace("POWERS", _powers())
"""The functions, in the order in which they use each other."""

// A policy that aicon-torch exported, in C++: load, reset, step.
//
//   aicon::Policy<double> policy("pusht.so");
//   const double *commands = policy.step(readings);  // once every dt
//
// A step allocates nothing and locks nothing.

#pragma once

#include <dlfcn.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace aicon {

// Real is double or float, as the policy was exported.
template <typename Real>
class Policy {
 public:
  // Loads a file and checks that it computes here what it did when it was exported. The file is
  // native code: load none that you would not execute.
  explicit Policy(const std::string &path) : library_(open(path)) {
    const int *sizes = static_cast<const int *>(find("aicon_sizes"));
    if (sizes[0] != kFormat) throw std::runtime_error(path + ": exported in another format");
    if (sizes[1] != static_cast<int>(sizeof(Real)))
      throw std::runtime_error(path + ": exported in another precision");

    step_ = reinterpret_cast<Step>(find("aicon_step"));
    blank_ = reinterpret_cast<Blank>(find("aicon_blank"));
    metadata_ = static_cast<const char *>(find("aicon_metadata"));
    if (!reinterpret_cast<Test>(find("aicon_test"))())
      throw std::runtime_error(path + ": computes something else here; export it again");

    readings_ = sizes[2];
    memory_.resize(sizes[3]);
    commands_.resize(sizes[4]);
    blank_(memory_.data());
  }

  // The next step is the first of an episode. Goals that were switched stay as they are.
  void reset() { starts_ = 1; }

  // One control step.
  //
  // Takes the readings of all sensors one after the other, in the order of the metadata, NaN where
  // there is none, then ages and executed actions, where the policy takes them; returns the commands,
  // which the next step overwrites. Readings that are gone too long bring the robot to rest.
  const Real *step(const Real *readings) {
    step_(1, &starts_, readings, memory_.data(), memory_.data(), commands_.data());
    starts_ = 0;
    return commands_.data();
  }

  // Number of readings and of commands.
  int readings() const { return readings_; }
  int commands() const { return static_cast<int>(commands_.size()); }

  // What the file says of itself, in JSON: sensors and units, actuators, goals, dt, ...
  const char *metadata() const { return metadata_; }

 private:
  static constexpr int kFormat = 1;
  using Step = void (*)(long, const unsigned char *, const void *, const void *, void *, void *);
  using Blank = void (*)(void *);
  using Test = int (*)();

  struct Close {
    void operator()(void *library) const { dlclose(library); }
  };
  using Library = std::unique_ptr<void, Close>;

  static Library open(const std::string &path) {
    // A name without a slash would be looked for among the system's libraries.
    const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
    Library library(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL));
    if (!library) throw std::runtime_error(dlerror());
    return library;
  }

  void *find(const char *name) {
    if (void *symbol = dlsym(library_.get(), name)) return symbol;
    throw std::runtime_error(std::string("not an exported policy: it has no ") + name);
  }

  Library library_;
  Step step_ = nullptr;
  Blank blank_ = nullptr;
  const char *metadata_ = nullptr;
  int readings_ = 0;
  std::vector<Real> memory_;
  std::vector<Real> commands_;
  unsigned char starts_ = 1;
};

}  // namespace aicon

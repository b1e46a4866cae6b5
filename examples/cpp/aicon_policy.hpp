// A policy that aicon-torch exported, in C++: load, reset, step.
//
//   aicon::Policy<double> policy("pusht.so");
//   const double *commands = policy.step(readings);  // once every dt
//
// A step allocates nothing and locks nothing.

#pragma once

#include <dlfcn.h>
#include <link.h>

#include <cstring>
#include <fstream>
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
    const int bytes = sizeof(Real);
    if (sizes[0] != kFormat)
      throw std::runtime_error(path + ": has format " + std::to_string(sizes[0]) +
                               ", and this class reads format " + std::to_string(kFormat));
    if (sizes[1] != bytes)
      throw std::runtime_error(path + ": computes in numbers of " + std::to_string(sizes[1]) +
                               " bytes, and this class in " + std::to_string(bytes));

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

  // The same, with their number checked.
  const Real *step(const std::vector<Real> &readings) {
    if (static_cast<int>(readings.size()) != readings_)
      throw std::invalid_argument("step: " + std::to_string(readings.size()) +
                                  " readings, expected " + std::to_string(readings_));
    return step(readings.data());
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
    check_whole(file);
    Library library(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL));
    if (!library) throw std::runtime_error(dlerror());
    return library;
  }

  // A file that is cut off would end the process when it is mapped.
  static void check_whole(const std::string &file) {
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    if (!stream) throw std::runtime_error(file + ": cannot be read");
    const std::size_t size = static_cast<std::size_t>(stream.tellg());

    ElfW(Ehdr) header{};
    stream.seekg(0);
    stream.read(reinterpret_cast<char *>(&header), sizeof header);
    if (!stream || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
      throw std::runtime_error(file + ": is no shared library");
    const std::size_t whole = header.e_shoff + std::size_t(header.e_shnum) * header.e_shentsize;
    if (size < whole)
      throw std::runtime_error(file + ": is cut off: " + std::to_string(size) + " of " +
                               std::to_string(whole) + " bytes");
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

// A policy that aicon-torch exported, in C++17: load, reset, step. On Linux, macOS and Windows.
//
//   aicon::Policy<double> policy("pusht.so");
//   const double *commands = policy.step(readings);  // once every dt
//   if (!policy.begins()) send(commands);
//
// A step allocates nothing and locks nothing.

#pragma once

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#else
#include <dlfcn.h>
#include <unistd.h>
#endif
#ifdef __linux__
#include <link.h>
#include <sys/mman.h>
#endif

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace aicon {

// A library out of what is in its file: looked at before anything of it runs, and loaded under a
// name that is nobody else's. The system takes a library whose name it knows for the one that it
// has, and maps its file, whose bytes may change below a running program.
class Library {
 public:
  explicit Library(const std::string &path) : path_(path) {
    std::ostringstream read;
    if (!(read << std::ifstream(path, std::ios::binary).rdbuf()))
      throw std::runtime_error(path + ": cannot be read, or is empty");
    const std::string content = read.str();

    check_end(content);
    check_seal(content);
    open(content);
    if (content.find(static_cast<const char *>(find("aicon_metadata"))) == std::string::npos)
      throw std::runtime_error(path + ": the system has loaded another library in its place");
  }

  void *find(const char *name) const {
#ifdef _WIN32
    void *symbol = reinterpret_cast<void *>(GetProcAddress(HMODULE(library_.get()), name));
#else
    void *symbol = dlsym(library_.get(), name);
#endif
    if (symbol) return symbol;
    throw std::runtime_error(path_ + ": not an exported policy: it has no " + name);
  }

  // The machine that this program runs on.
  static std::string this_machine() {
#if defined(__x86_64__) || defined(_M_X64)
    const std::string processor = "x86_64";
#elif defined(__aarch64__) || defined(_M_ARM64)
    const std::string processor = "aarch64";
#elif defined(__ARM_ARCH) && __ARM_ARCH >= 7
    const std::string processor = "armv7";
#elif defined(__riscv) && __riscv_xlen == 64
    const std::string processor = "riscv64";
#else
    const std::string processor = "unknown";
#endif
#if defined(_WIN32)
    return processor + "-windows";
#elif defined(__APPLE__)
    return processor + "-macos";
#else
    return processor + "-linux";
#endif
  }

 private:
  // Unloads a library, and forgets the file that it was loaded from.
  struct Close {
    int descriptor;    // of a file in memory, or -1
    std::string copy;  // a private copy that cannot be deleted before

    Close() : descriptor(-1) {}
    Close(int opened, const std::string &copied) : descriptor(opened), copy(copied) {}

    void operator()(void *library) const {
#ifdef _WIN32
      FreeLibrary(HMODULE(library));
      DeleteFileA(copy.c_str());
#else
      dlclose(library);
      if (descriptor >= 0) ::close(descriptor);
#endif
    }
  };

  // A file that is cut off would end the process when it is mapped.
  void check_end(const std::string &content) const {
#ifdef __linux__
    ElfW(Ehdr) header{};
    if (content.size() < sizeof header || content.compare(0, SELFMAG, ELFMAG) != 0) return;
    std::memcpy(&header, content.data(), sizeof header);
    const std::size_t whole = header.e_shoff + std::size_t(header.e_shnum) * header.e_shentsize;
    if (header.e_ident[EI_CLASS] == (sizeof(void *) == 8 ? ELFCLASS64 : ELFCLASS32) &&
        content.size() < whole)
      throw std::runtime_error(path_ + ": is cut off: " + std::to_string(content.size()) + " of " +
                               std::to_string(whole) + " bytes");
#else
    (void)content;
#endif
  }

  // The last line says for which machine it is, and ends in a checksum of all before it. What was
  // compiled from its source elsewhere has none.
  void check_seal(const std::string &content) const {
    const std::string begin = "\naicon-torch library for ", sum = ", checksum ";
    const std::size_t longest = 200, digits = 9, size = content.size();
    const std::size_t line = content.rfind(begin);
    if (line == std::string::npos || size - line > longest ||
        size - line < begin.size() + sum.size() + digits ||
        content.compare(size - digits - sum.size(), sum.size(), sum) != 0) {
      if (content.find("aicon-torch: this file ends in a line with its checksum") ==
          std::string::npos)
        return;
      throw std::runtime_error(path_ + ": is damaged or cut off: its last line is missing");
    }

    char found[digits + 1];
    std::snprintf(found, sizeof found, "%08lx\n", checksum(content.data(), size - digits));
    if (content.compare(size - digits, digits, found) != 0)
      throw std::runtime_error(path_ + ": is damaged: its checksum is not that of its content");

    const std::size_t start = line + begin.size();
    const std::string target = content.substr(start, content.find_first_of(" ,", start) - start);
    if (target != this_machine())
      throw std::runtime_error(path_ + ": is a library for " + target + ", and this machine is " +
                               this_machine());
  }

  // CRC-32, as in zlib.
  static unsigned long checksum(const char *content, std::size_t size) {
    std::uint32_t table[256];
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
      table[byte] = byte;
      for (int bit = 0; bit < 8; ++bit)
        table[byte] = (table[byte] >> 1) ^ (table[byte] & 1 ? 0xEDB88320u : 0u);
    }
    std::uint32_t rest = ~std::uint32_t(0);
    for (std::size_t i = 0; i < size; ++i)
      rest = (rest >> 8) ^ table[(rest ^ static_cast<unsigned char>(content[i])) & 255];
    return std::uint32_t(~rest);
  }

#ifdef _WIN32
  void open(const std::string &content) {
    char folder[MAX_PATH + 1], copy[MAX_PATH + 1];
    if (!GetTempPathA(sizeof folder, folder) || !GetTempFileNameA(folder, "aic", 0, copy))
      throw std::runtime_error(path_ + ": there is no folder for a private copy");
    std::ofstream(copy, std::ios::binary) << content;

    HMODULE library = LoadLibraryA(copy);
    const unsigned long error = GetLastError();
    if (!library) {
      DeleteFileA(copy);
      throw std::runtime_error(path_ + ": is no library for this machine, " + this_machine() +
                               ": error " + std::to_string(error));
    }
    library_ = {library, Close(-1, copy)};
  }
#else
  void open(const std::string &content) {
    if (open_in_memory(content)) return;

    // What is in memory may not be allowed to run: a private copy.
    const char *folder = std::getenv("TMPDIR");
    std::string copy = std::string(folder && *folder ? folder : "/tmp") + "/aicon_policy_XXXXXX";
    const int descriptor = mkstemp(&copy[0]);
    if (descriptor < 0) throw std::runtime_error(path_ + ": no private copy can be made: " + copy);
    const bool is_written = write_all(descriptor, content);
    ::close(descriptor);

    if (!is_written) throw std::runtime_error(path_ + ": a private copy cannot be written");

    void *library = dlopen(copy.c_str(), RTLD_NOW | RTLD_LOCAL);
    ::unlink(copy.c_str());
    if (!library) {
      std::string reason = dlerror();
      if (reason.compare(0, copy.size(), copy) == 0) reason.erase(0, copy.size());
      throw std::runtime_error(path_ + ": is no library for this machine, " + this_machine() + reason);
    }
    library_ = {library, Close()};
  }

  // The number of its descriptor is its name, and another file's only when it is unloaded.
  bool open_in_memory(const std::string &content) {
#ifdef __linux__
    const int descriptor = memfd_create("aicon_policy", MFD_CLOEXEC);
    if (descriptor < 0) return false;
    const std::string name = "/proc/self/fd/" + std::to_string(descriptor);
    if (write_all(descriptor, content))
      library_ = {dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL), Close(descriptor, "")};
    if (library_) return true;
    ::close(descriptor);
#else
    (void)content;
#endif
    return false;
  }

  static bool write_all(int descriptor, const std::string &content) {
    std::size_t written = 0;
    while (written < content.size()) {
      const ssize_t count = ::write(descriptor, &content[written], content.size() - written);
      if (count <= 0) return false;
      written += static_cast<std::size_t>(count);
    }
    return true;
  }
#endif

  std::string path_;
  std::unique_ptr<void, Close> library_;
};

// Real is double or float, as the policy was exported.
template <typename Real>
class Policy {
 public:
  // Loads a file and checks that it is whole and computes here what it did when it was exported.
  // The file is native code: load none that you would not execute.
  explicit Policy(const std::string &path) : library_(path) {
    const int *sizes = static_cast<const int *>(library_.find("aicon_sizes"));
    const int bytes = sizeof(Real);
    if (sizes[0] != kFormat)
      throw std::runtime_error(path + ": has format " + std::to_string(sizes[0]) +
                               ", and this class reads format " + std::to_string(kFormat));
    if (sizes[1] != bytes)
      throw std::runtime_error(path + ": computes in numbers of " + std::to_string(sizes[1]) +
                               " bytes, and this class in " + std::to_string(bytes));

    step_ = reinterpret_cast<Step>(library_.find("aicon_step"));
    blank_ = reinterpret_cast<Blank>(library_.find("aicon_blank"));
    begins_ = reinterpret_cast<Begins>(library_.find("aicon_begins"));
    metadata_ = static_cast<const char *>(library_.find("aicon_metadata"));
    if (!reinterpret_cast<Test>(library_.find("aicon_test"))())
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

  // Whether the episode has yet to begin, as a reading that it begins with has not come, or begins
  // anew, as the step broke: send no command then, which may be a place.
  bool begins() const { return starts_ || begins_(memory_.data()) != 0; }

  // Number of readings and of commands.
  int readings() const { return readings_; }
  int commands() const { return static_cast<int>(commands_.size()); }

  // The memory, which lives from step to step: the entries that the metadata lists, one after the
  // other. A copy of it is the moment; what is assigned has to be as long.
  std::vector<Real> &memory() { return memory_; }
  const std::vector<Real> &memory() const { return memory_; }

  // What the file says of itself, in JSON: sensors and units, actuators, goals, dt, ...
  const char *metadata() const { return metadata_; }

 private:
  static constexpr int kFormat = 2;
  using Step = void (*)(long, const unsigned char *, const void *, const void *, void *, void *);
  using Blank = void (*)(void *);
  using Begins = int (*)(const void *);
  using Test = int (*)();

  Library library_;
  Step step_ = nullptr;
  Blank blank_ = nullptr;
  Begins begins_ = nullptr;
  const char *metadata_ = nullptr;
  int readings_ = 0;
  std::vector<Real> memory_;
  std::vector<Real> commands_;
  unsigned char starts_ = 1;
};

}  // namespace aicon

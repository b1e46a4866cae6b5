// Replays recorded readings through an exported policy, and tells how long a step takes.
//
//   replay FOLDER [STEPS]
//
// FOLDER has policy.so (.dylib, .dll), and rows of doubles in readings.bin, commands.bin and starts.bin (1 where an episode
// begins), as scripts/record_replay.py writes them. The commands must be those that were recorded, bit by bit.

#ifndef _WIN32
#include <sys/resource.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "aicon_policy.hpp"

// Every allocation of this process counts, those of the library included.
static long allocations = 0;
void *operator new(std::size_t size) {
  ++allocations;
  if (void *memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void *memory) noexcept { std::free(memory); }
void operator delete(void *memory, std::size_t) noexcept { std::free(memory); }

static std::vector<double> read_doubles(const std::string &path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<double> values(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char *>(values.data()), values.size() * sizeof(double));
  return values;
}

#if defined(_WIN32)
static const char *const kLibrary = "/policy.dll";
#elif defined(__APPLE__)
static const char *const kLibrary = "/policy.dylib";
#else
static const char *const kLibrary = "/policy.so";
#endif

static long resident_kilobytes() {
#ifdef _WIN32
  return 0;
#else
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
#endif
}

static void replay(const std::string &folder, long steps) {
  using Clock = std::chrono::steady_clock;
  const auto microseconds = [](Clock::duration taken) {
    return std::chrono::duration<double, std::micro>(taken).count();
  };

  const auto before_loading = Clock::now();
  aicon::Policy<double> policy(folder + kLibrary);
  std::printf("loaded in %.1f ms\n", microseconds(Clock::now() - before_loading) / 1e3);

  const std::vector<double> readings = read_doubles(folder + "/readings.bin");
  const std::vector<double> commands = read_doubles(folder + "/commands.bin");
  const std::vector<double> starts = read_doubles(folder + "/starts.bin");
  const long rows = static_cast<long>(starts.size());
  if (rows == 0 || static_cast<long>(readings.size()) != rows * policy.readings() ||
      static_cast<long>(commands.size()) != rows * policy.commands())
    throw std::runtime_error("readings.bin, commands.bin and starts.bin do not fit the policy");

  // The episodes again and again.
  std::vector<float> taken(static_cast<std::size_t>(steps));
  const long memory_before = resident_kilobytes(), allocations_before = allocations;
  for (long step = 0; step < steps; ++step) {
    const long row = step % rows;
    if (starts[row] != 0) policy.reset();

    const auto start = Clock::now();
    const double *command = policy.step(&readings[row * policy.readings()]);
    taken[step] = static_cast<float>(microseconds(Clock::now() - start));

    const double *recorded = &commands[row * policy.commands()];
    if (std::memcmp(command, recorded, policy.commands() * sizeof(double)) != 0)
      throw std::runtime_error("step " + std::to_string(step) + ": another command than recorded");
  }
  const long allocated = allocations - allocations_before;
  const long grown = resident_kilobytes() - memory_before;

  std::sort(taken.begin(), taken.end());
  std::printf("%ld steps, every command as recorded\n", steps);
  std::printf("one step: median %.2f us, 99th percentile %.2f us, largest %.1f us\n",
              taken[steps / 2], taken[steps * 99 / 100], taken[steps - 1]);
  std::printf("allocations in the steps: %ld; memory grew by %ld kB\n", allocated, grown);
}

int main(int count, char **words) {
  if (count < 2) {
    std::fprintf(stderr, "usage: replay FOLDER [STEPS]\n");
    return 2;
  }
  try {
    replay(words[1], count > 2 ? std::atol(words[2]) : 100000);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "replay: %s\n", error.what());
    return 1;
  }
  return 0;
}

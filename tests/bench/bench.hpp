#pragma once
// Rows of scripts/bench: each does its work on files in a folder and says the best of several
// times.

#include <time.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace trammel::bench {

/// Raw doubles, as numpy's tofile writes them.
inline std::vector<double> read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw std::runtime_error("no such file: " + file.string());
  std::vector<double> values(static_cast<std::size_t>(in.tellg()) / sizeof(double));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(values.data()),
          static_cast<std::streamsize>(values.size() * sizeof(double)));
  return values;
}

inline void write(const std::filesystem::path& file, const double* values, std::size_t n) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values),
            static_cast<std::streamsize>(n * sizeof(double)));
}

inline double clock_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
/// What this process has had of the processors: others on the machine hardly change it.
inline double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Shortest of `times` runs, seconds.
inline double best(int times, const std::function<void()>& work,
                   double (*seconds)() = processor_s) {
  double least = 1e300;
  for (int k = 0; k < times; ++k) {
    const double start = seconds();
    work();
    least = std::min(least, seconds() - start);
  }
  return least;
}

void record(const std::filesystem::path& folder);  // bench_store.cpp
void import_readings(const std::filesystem::path& folder);

}  // namespace trammel::bench

#pragma once
// Rows of scripts/bench: each does its work on files in a folder and says the best of several
// times.

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

/// Shortest of `times` runs, seconds.
inline double best(int times, const std::function<void()>& work) {
  double least = 1e300;
  for (int k = 0; k < times; ++k) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count());
  }
  return least;
}

void record(const std::filesystem::path& folder);  // bench_store.cpp
void import_readings(const std::filesystem::path& folder);

}  // namespace trammel::bench

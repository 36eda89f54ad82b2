#include "tests/stress/mutate.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <stdexcept>
#include <thread>

#include "core/error.hpp"
#include "core/statistics/random.hpp"

namespace trammel::test {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kHang{5};
constexpr std::int64_t kBatch = 500;  // mutations in one process

const std::array<std::string_view, 34> kTokens = {"NaN",
                                                  "-Infinity",
                                                  "1e999",
                                                  "-1e-999",
                                                  "0x10",
                                                  "1e308",
                                                  "-0",
                                                  "9223372036854775808",
                                                  "1,5",
                                                  "null",
                                                  "true",
                                                  "[]",
                                                  "{}",
                                                  "\"\"",
                                                  "\"",
                                                  "\\",
                                                  "\\u0000",
                                                  "\\ud800",
                                                  "\xff\xfe",
                                                  "\xc2\x9b",
                                                  "\xef\xbb\xbf",
                                                  "\r",
                                                  "\n\n",
                                                  ",",
                                                  ",,,,",
                                                  ":",
                                                  "[",
                                                  "]",
                                                  "{",
                                                  "}",
                                                  "=cmd|' /C calc'!A0",
                                                  "../../../etc/passwd",
                                                  "sim:",
                                                  "2147483648"};

/// Written by the child, read by the parent: how far it has come.
struct Shared {
  std::atomic<std::int64_t> at;
  std::atomic<std::int64_t> refused;
};

void change(std::string& content, Random& random) {
  const auto place = [&](std::size_t extra = 0) {
    return static_cast<std::size_t>(random.below(content.size() + extra));
  };
  if (content.empty()) content = "x";
  switch (random.below(9)) {
    case 0:
      content[place()] ^= static_cast<char>(1U << random.below(8));
      break;
    case 1:
      content[place()] = static_cast<char>(random.below(256));
      break;
    case 2: {  // a digit or a sign
      const std::size_t at =
          std::min(content.find_first_of("0123456789", place()), content.size() - 1);
      content[at] = "0123456789-+.eE"[random.below(15)];
      break;
    }
    case 3:
      content.insert(place(1), kTokens[random.below(kTokens.size())]);
      break;
    case 4: {
      const std::size_t at = place();
      content.erase(at, random.below(std::min<std::size_t>(content.size() - at, 64)) + 1);
      break;
    }
    case 5: {  // again
      const std::size_t at = place();
      content.insert(at, content.substr(at, random.below(200) + 1));
      break;
    }
    case 6:
      content.resize(place());
      break;
    case 7:  // deep, or long
      content.insert(place(1), std::string(static_cast<std::size_t>(random.below(3000)),
                                           "[{\"9 ,"[random.below(6)]));
      break;
    default: {  // bytes of one place over another
      const std::size_t n = std::min<std::size_t>(content.size() / 2, random.below(32) + 1);
      const std::size_t from = place() % (content.size() - n + 1);
      const std::size_t to = place() % (content.size() - n + 1);
      content.replace(to, n, content.substr(from, n));
    }
  }
}

std::filesystem::path place_of(const Importer& importer, const std::filesystem::path& folder) {
  std::filesystem::remove_all(folder / importer.name);
  std::filesystem::create_directories(folder / importer.name);
  if (importer.prepare) importer.prepare(folder / importer.name);
  return folder / importer.name / importer.file;
}

/// In the child: an exception of another kind ends it.
void take_some(const Importer& importer, const std::filesystem::path& file, std::uint64_t seed,
               std::int64_t from, std::int64_t to, Shared& shared) {
  for (std::int64_t n = from; n < to; ++n) {
    shared.at = n;
    for (const char* beside : {"-wal", "-shm", "-journal"}) {
      std::error_code ignored;
      std::filesystem::remove(file.string() + beside, ignored);
    }
    std::ofstream(file, std::ios::binary) << mutated(importer, seed, n);
    try {
      importer.take(file);
    } catch (const Error&) {
      ++shared.refused;
    }
  }
  shared.at = to;
}

enum class End { done, crashed, hung };

End wait_for(pid_t child, const Shared& shared) {
  std::int64_t last = -1;
  Clock::time_point since = Clock::now();
  for (int status = 0;;) {
    if (waitpid(child, &status, WNOHANG) == child) {
      return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? End::done : End::crashed;
    }
    if (shared.at != last) {
      last = shared.at;
      since = Clock::now();
    } else if (Clock::now() - since > kHang) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return End::hung;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

std::string mutated(const Importer& importer, std::uint64_t seed, std::int64_t n) {
  Random random(seed + 0x9E3779B97F4A7C15ULL * static_cast<std::uint64_t>(n + 1));
  std::string content = importer.seeds[random.below(importer.seeds.size())];
  if (random.below(20) == 0) {
    const std::string& other = importer.seeds[random.below(importer.seeds.size())];
    content = content.substr(0, random.below(content.size() + 1)) +
              other.substr(random.below(other.size() + 1));
  }
  for (std::uint64_t left = random.below(8) + 1; left > 0; --left) change(content, random);
  return content;
}

Importer faulty_importer() {
  return {"control", "control.txt", {"0123", "0789"}, {}, [](const std::filesystem::path& file) {
            std::string text;
            std::ifstream(file) >> text;
            if (text.find('3') != text.npos) std::abort();
            while (text.find('7') != text.npos) pause();
          }};
}

MutationCount mutate(const Importer& importer, const std::filesystem::path& folder, double seconds,
                     std::int64_t most, std::uint64_t seed) {
  void* memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("mmap");
  auto* shared = new (memory) Shared{};
  MutationCount count;
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  while (count.tried < most && Clock::now() < until) {
    const std::int64_t to = std::min(most, count.tried + kBatch);
    const auto file = place_of(importer, folder);
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("fork");
    if (child == 0) {
      try {
        take_some(importer, file, seed, count.tried, to, *shared);
      } catch (const std::exception& error) {
        std::fprintf(stderr, "%s %lld: %s\n", importer.name.c_str(),
                     static_cast<long long>(shared->at), error.what());
        _exit(1);
      }
      _exit(0);
    }
    const End end = wait_for(child, *shared);
    count.tried = end == End::done ? to : shared->at + 1;
    count.crashes += end == End::crashed ? 1 : 0;
    count.hangs += end == End::hung ? 1 : 0;
    if (end == End::done) continue;
    const std::string name = importer.name + "-" + std::to_string(shared->at);
    std::ofstream(folder / name, std::ios::binary) << mutated(importer, seed, shared->at);
    if (count.first_problem.empty()) count.first_problem = (folder / name).string();
  }
  count.refused = shared->refused;
  munmap(memory, sizeof(Shared));
  return count;
}

}  // namespace trammel::test

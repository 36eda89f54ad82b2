// libFuzzer on an importer: trammel_fuzz IMPORTER [options of libFuzzer]. What is coverage-guided
// here the sweep of mutate.cpp does blindly, with clang as without.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "core/error.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/support/temporary.hpp"

namespace {

using trammel::test::Importer;

struct Run {
  trammel::tests::TemporaryFolder folder;
  Importer importer;
  std::filesystem::path file;
};

// Lives as long as the process: libFuzzer leaves by exit().
Run& run() {
  static Run all;
  return all;
}

[[noreturn]] void usage(const std::vector<Importer>& known) {
  std::fprintf(stderr, "usage: trammel_fuzz IMPORTER [options of libFuzzer]\n");
  for (const Importer& importer : known) std::fprintf(stderr, "  %s\n", importer.name.c_str());
  std::exit(2);
}

}  // namespace

/// Takes the importer's name off the line and puts a corpus of its seeds there.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  std::vector<Importer> known = trammel::test::importers(run().folder.path());
  if (*argc < 2) usage(known);
  const auto chosen = std::ranges::find(known, std::string((*argv)[1]), &Importer::name);
  if (chosen == known.end()) usage(known);
  run().importer = std::move(*chosen);
  const Importer& importer = run().importer;
  const auto corpus = run().folder.path() / "corpus", place = run().folder.path() / "place";
  std::filesystem::create_directory(corpus);
  std::filesystem::create_directory(place);
  for (std::size_t k = 0; k < importer.seeds.size(); ++k) {
    std::ofstream(corpus / std::to_string(k), std::ios::binary) << importer.seeds[k];
  }
  if (importer.prepare) importer.prepare(place);
  run().file = place / importer.file;
  static std::string folder = corpus.string();
  (*argv)[1] = folder.data();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const char* beside : {"-wal", "-shm", "-journal"}) {
    std::error_code ignored;
    std::filesystem::remove(run().file.string() + beside, ignored);
  }
  std::ofstream(run().file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    run().importer.take(run().file);
  } catch (const trammel::Error&) {
    // refused, as it may be
  }
  return 0;
}

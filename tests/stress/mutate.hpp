#pragma once
// Files from strangers: good ones, changed at random, given to each importer.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace trammel::test {

/// What a mutated file is given to. It may refuse (trammel::Error) or accept; nothing else.
struct Importer {
  std::string name;
  std::string file;                // the mutated file's name, in a folder of its own
  std::vector<std::string> seeds;  // contents of good files
  std::function<void(const std::filesystem::path&)> prepare = {};  // what stands beside it
  std::function<void(const std::filesystem::path&)> take = {};
};

/// Every kind of file that the program reads: campaigns, readings, commands, plans, robots,
/// protocols, mechanisms, points of trackers and their layouts, stages, trackers, databases.
/// `folder` is used to make the seed database.
std::vector<Importer> importers(const std::filesystem::path& folder);

/// The control: it crashes at every file with a '3' and does not end at one with a '7'.
Importer faulty_importer();

/// The n-th mutation of the importer's seeds: 1 to 8 changes of bits, bytes, ranges, numbers and
/// nesting, or a splice of two. The same for the same seed and n.
std::string mutated(const Importer& importer, std::uint64_t seed, std::int64_t n);

struct MutationCount {
  std::int64_t tried = 0;
  std::int64_t refused = 0;  // the rest was taken: still good, or changed where it may
  int crashes = 0;           // sanitizer reports, signals, exceptions of other kinds
  int hangs = 0;             // longer than 5 s
  std::string first_problem = {};
};

/// Feeds mutations for `seconds`, or `most` of them, in processes of their own. What crashes or
/// hangs is kept in `folder` by its number.
MutationCount mutate(const Importer& importer, const std::filesystem::path& folder, double seconds,
                     std::int64_t most, std::uint64_t seed);

}  // namespace trammel::test

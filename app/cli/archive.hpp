#pragma once
// `trammel archive VERB`: what its verbs take. The program trammel-archive runs them; this one
// knows them for its help, its man page and completion, and executes that one (main.cpp).

#include <string>
#include <vector>

#include "app/cli/query.hpp"

namespace trammel::cli {

/// What all verbs share, and what each has.
struct ArchiveOptions {
  std::string uri;  // --archive, or the URI of init
  bool insecure = false;
  std::string station;
  std::vector<std::string> campaigns;
  std::string to;
  bool with_results = false;
  int newest = 50;
  std::string stage, parameters, where = "true";
  int last = 0;  // campaigns to queue; 0: all
  bool force = false;
  unsigned jobs = 1;
  bool until_empty = false;
  double lease_s = 60;
  QueryOptions query = {};
};

using ArchiveRun = ExitCode (*)(const ArchiveOptions&, Context&);
struct ArchiveRuns {
  ArchiveRun init = nullptr, push = nullptr, pull = nullptr, list = nullptr, verify = nullptr,
             status = nullptr, rerun = nullptr, work = nullptr, query = nullptr;
};

void setup_archive(Command app, Context& context, const ArchiveRuns& runs);

/// The first word that is neither an option nor the value of one that stands anywhere.
std::string first_command(const std::vector<std::string>& words);

/// Words for trammel-archive: its noun, or `query` with --archive.
/// Proof: archive_program_test.cpp, views_test.cpp
bool is_for_the_archive(const std::vector<std::string>& words);

}  // namespace trammel::cli

#pragma once
// What can stand next on a command line: the shells ask at each TAB, by `trammel complete`.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct Candidate {
  std::string word;
  std::string what;  // one line, may be empty
};

enum class Paths { none, files, folders };

struct Candidates {
  std::vector<Candidate> words;
  Paths paths = Paths::none;  // names of these too: the shell knows how
};

/// What the line says so far, by the names of values: {"CAMPAIGN": "paper", "--db": "lab.db"}.
using Given = std::map<std::string, std::string>;

/// The values that a name (CAMPAIGN, JOB, …) can take, whatever was typed of it.
using Values = std::function<Candidates(const std::string& name, const Given& given)>;

/// The words that can stand in the place of the last of `words`, beginning as it does: commands,
/// options not given yet, choices, and what `values` has. Walks the tree of commands, so what is
/// added there is completed. Proof: completion_test.cpp.
Candidates candidates(Command app, const std::vector<std::string>& words, const Values& values);

/// The values of stored things, from the database of the line or of `context`; a database that
/// cannot be read has none.
Candidates stored_values(const std::string& name, const Given& given, const Context& context);

}  // namespace trammel::cli

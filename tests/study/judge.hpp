#pragma once
// Is an answer right? What the readings allow to say, against what was said.

#include <string>

#include "core/diagnose/diagnose.hpp"
#include "tests/study/campaigns.hpp"

namespace trammel::tests {

/// What the readings of a case allow.
enum class Expected {
  nothing,         // clean
  outliers,        // single bad readings, all of them
  named,           // the hidden effects, and no others
  among,           // named, or ambiguous with the hidden effects among the candidates
  unexplained,     // outside the catalogue, and far from all of it
  not_confident,   // outside the catalogue, and the catalogue comes near: unexplained or ambiguous
  hardly_visible,  // outside the catalogue, and next to nothing is left of it: no name
};

struct Judgement {
  Expected expected = Expected::nothing;
  Verdict verdict = Verdict::unexplained;
  enum class Mark { right, abstained, wrong } mark = Mark::abstained;
  double margin = 0;  // chi^2 that the nearest other set of the catalogue leaves, without noise
  bool names_right = false;
  int values = 0, values_good = 0;  // hidden parameters; within 4 standard deviations
  int counted = 0, covered = 0;     // values told or hidden; within 2 standard deviations
  std::string missed;               // the others, in words
  double unseen_rms_mm = 0;         // predicted minus true pose, where no reading was fitted
  bool closed = false;              // that is at most half a sigma
  [[nodiscard]] bool right() const { return mark == Mark::right; }
};

/// Margins from kClear on must be named, from kFar on must be told to be outside the catalogue:
/// there the nearest other explanation loses by 20:1 in nearly all repetitions.
inline constexpr double kVisible = 30;
inline constexpr double kClear = 18;
inline constexpr double kFar = 150;

Judgement judge(const HiddenCase& hidden, const Diagnosis& diagnosis);

/// Ties of a first diagnosis that its points can decide, and those that the second, made with these
/// points, no longer holds for as good; and whether what was hidden is among what it does hold.
struct Round {
  int ties = 0, decided = 0;
  int asked = 0, kept = 0;  // campaigns
};
Round judge_round(const HiddenCase& hidden, const Diagnosis& first, const Diagnosis& second);

/// "explained backlash, hidden backlash, margin 80".
std::string in_words(const HiddenCase& hidden, const Diagnosis& diagnosis,
                     const Judgement& judgement);

struct Tally {
  int cases = 0;
  int named = 0, ambiguous = 0, silent = 0, unexplained = 0;
  int wrong = 0;  // a confident untruth: other names than were hidden
  int right = 0, abstained = 0;
  int values = 0, values_good = 0, explained = 0, closed = 0;
  int counted = 0, covered = 0;
  void add(const Judgement& judgement);
  void add(const Tally& other);
};

}  // namespace trammel::tests

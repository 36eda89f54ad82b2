#pragma once
// The screen at every door: are wires, signs, frames, units, columns, clocks and cells right,
// before any number is fitted to them?

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// What can be wrong with a campaign's data by its kind; none of these is a physical effect of a
/// sound machine.
enum class Mistake {
  drives_swapped,    // commands of two or three drives changed places
  drive_reversed,    // a rail counts backwards
  phi_offset,        // orientations are a constant off, positions stand
  frame_turned,      // the tracker's frame is turned about the origin
  frame_shifted,     // its origin lies elsewhere
  frame_mirrored,    // seen from below, axes swapped, or an axis with the wrong sign
  scale,             // lengths in another unit
  radians,           // orientations in another unit than degrees
  working_mode,      // the links stand on the other side of the platform's joints
  exchanged,         // columns of target and measured pose changed places
  deviations,        // what was measured less the target stands where the measured pose is due
  shifted_rows,      // poses stand some rows too early or too late
  mechanism,         // the commands are not this mechanism's for these targets
  nominal,           // measured equals target
  sigma_unit,        // the stated sigma is of another unit
  temperature_unit,  // temperatures in kelvin or degrees Fahrenheit
  clock,             // time runs backwards
  duplicated,        // one reading stands twice or more
  copied,            // validation readings that are copies of fitted ones
  unknown_epoch,     // validation in an epoch that no fit can see
  moved_frame,       // validation readings lie elsewhere than the fitted ones
  other_commands,    // commands of another model than the nominal one
  missing_cells,     // times or temperatures that some readings have and others have not
  stale,             // a reading repeats the pose of the one before
  missed,            // 0, 0, 0: the tracker saw nothing
  far,               // a reading without any good neighbour
};

/// gross: no number made of these data means anything, and doors refuse; doubt: it is reported at
/// every door, and `campaign check` is not content; remark: a person should know.
enum class Gravity { gross, doubt, remark };

struct MistakeRule {
  Mistake mistake;
  const char* name;
  Gravity gravity;
  const char* advice;  // what to do
};
/// The one table of who refuses and who reports: gross mistakes are refused by `campaign import`,
/// `session run` and `calibrate`; `diagnose` and `report` print them; `campaign check` answers 4
/// for them, and 5 for doubts.
std::span<const MistakeRule> mistake_rules();
const MistakeRule& rule_of(Mistake mistake);
std::string to_string(Mistake mistake);
std::string to_string(Gravity gravity);

struct Suspicion {
  Mistake kind = Mistake::mechanism;
  std::string what;            // "drives 1 and 2 are swapped"
  std::string why;             // how far the commands are from the readings as they are, and so
  std::vector<int> seqs = {};  // empty: all readings
};

/// A walk under a correction: its commands are not the nominal ones.
struct CorrectedWalk {
  std::string name;
  std::vector<Reading> readings;
};

/// Everything the screen finds: gross mistakes (gross.hpp), two at most, and where there are none
/// what else is doubtful or worth a remark (doubts.hpp, bad_readings.hpp), in the order of the
/// table; then the same of each walk under a correction, for itself. `held`: epochs between which
/// the set-up held are one. Proof: each kind put into a clean
/// campaign is named, and clean ones of several designs are not suspected
/// (tests/core/measure/mistakes_test.cpp, tests/core/measure/screen_test.cpp).
std::vector<Suspicion> screened(const Campaign& campaign,
                                std::span<const std::pair<int, int>> held = {},
                                std::span<const CorrectedWalk> corrected = {});

[[nodiscard]] bool is_gross(const std::vector<Suspicion>& found);

/// "seq 41", "seqs 3, 4 and 18 more", "all readings"
std::string seqs_in_words(const std::vector<int>& seqs);

/// What was found in one sentence each, for people: "frame_mirrored: x has the wrong sign (all
/// readings); why; advice".
std::string in_words(const Suspicion& found);

/// The findings that are gross in one sentence, "…; or …"; empty: none is.
std::string gross_in_words(const std::vector<Suspicion>& found);

/// Throws InputError that names the hypotheses where one of the findings is gross; `hint` says what
/// the door offers besides putting it right. Proof: tests/core/measure/screen_test.cpp.
void require_sound(const Campaign& campaign, const std::vector<Suspicion>& found,
                   const std::string& hint);

/// `phi` by whole turns as near to `target` as it gets; itself, bit for bit, within half a turn.
double near_target_rad(double phi_rad, double target_rad);

}  // namespace trammel

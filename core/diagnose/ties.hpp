#pragma once
// What the named set could be mistaken for, as ties that further points may break; and the sets
// that lost.

#include <optional>
#include <string>
#include <vector>

#include "core/diagnose/audit.hpp"
#include "core/diagnose/look_alikes.hpp"
#include "core/diagnose/next_points.hpp"
#include "core/diagnose/selection.hpp"

namespace trammel {

/// `lead`: of `best` in score; 0 for a structural tie.
Tie tie_between(const Library& library, const Candidate& best, const Candidate& rival, double lead);

/// A shape without a name in place of the whole of `best`, or of that one of its effects which it
/// imitates most closely on the readings of `space`.
Tie tie_with_unnamed(const ResidualSpace& space, const Library& library, const Candidate& best,
                     const Shape& shape, double lead);

/// A look-alike (friction with memory, a lagging thermometer, …) in place of the effects of `best`
/// that it stands for.
Tie tie_with_look_alike(const Library& library, const Candidate& best, const LookAlike& alike);

/// A memory of the last move, decaying over `length_mm`, in place of the backlash of `best`: where
/// all approaches have that one length the two are the same data. Nothing without backlash.
std::optional<Tie> tie_with_memory(const Library& library, const Candidate& best, double length_mm);

/// Structure that has no name, as `shape` has it, against the best the catalogue could do (`tried`,
/// which may be empty): points that show it again. What happened once in time no point shows.
Tie tie_of_unexplained(const ResidualSpace& space, const Library& library, const Candidate& tried,
                       const Shape& shape);

/// Effects that this design can't show, though their conditions are recorded: a twentieth of its
/// usual maximum should not hide an effect that nothing shows, nor the maximum itself one that only
/// an unusual size would. What `model` has named may be of any size.
std::vector<Tie> blind_ties(const std::vector<AuditRow>& audit, const RobotModel& model);

/// A set of effects that was tried and lost.
struct Considered {
  std::vector<std::string> names;
  int parameters = 0;
  double behind = 0;  // in score (chi^2 less the price of names and parameters), against the best
  bool usual = true;  // every value within its usual range
};

/// The best sets that are neither rivals nor supersets of `best`, at most `most`, by rising
/// distance.
std::vector<Considered> runners_up(const Candidate& best, const std::vector<Candidate>& all,
                                   std::size_t most = 3);

}  // namespace trammel

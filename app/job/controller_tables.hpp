#pragma once
// A correction as the files that controllers read: a table for each drive, by its own position.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/job/compensation_table.hpp"
#include "core/calibrate/correction.hpp"
#include "core/calibrate/drive_table.hpp"

namespace trammel::job {

/// One drive's corrections, to be added to what is commanded; and what they leave.
struct DriveTables {
  DriveTable forward, reverse;  // arriving with growing, with falling displacement
  TableError before;            // of the correction without a table
  TableError left;              // of the correction by the table: also what other rails do to it
  TableError grid;              // of a table with half the step by this one
};

struct ControllerTables {
  std::vector<DriveTables> drives;  // of the machine, in order
  int n_targets = 0, n_unreachable = 0;
};

inline constexpr std::size_t kLinuxCncKnots = 256;  // EMCMOT_COMP_SIZE of LinuxCNC 2.9

/// Tables with knots every `knot_mm` of the displacements, fitted to the correction at the targets
/// of `grid` that the machine can go to (an axis: those on its line), each approached with all
/// drives growing and with all drives falling.
/// Proof: controller_tables_test.cpp. Throws InputError as fit_drive_table.
ControllerTables controller_tables(const Correction& correction, const NominalMachine& machine,
                                   const TableRequest& grid, double knot_mm);

/// A file, and what it is called.
struct ControllerFile {
  std::string name, text;
};

/// LinuxCNC: a COMP_FILE for each joint, named STEM.N.comp, in lines "nominal forward reverse";
/// forward and reverse are added to the motor's command (COMP_FILE_TYPE = 1). No comments: its
/// reader ends at the first line that is not three numbers.
/// Source: usrmotLoadComp of LinuxCNC 2.9. Proof: in its simulator (linuxcnc_test.cpp).
std::vector<ControllerFile> linuxcnc_files(const ControllerTables& tables, const std::string& stem);
/// What goes into its INI file.
std::string linuxcnc_ini(const std::vector<ControllerFile>& files);

/// Aerotech: one file with a 1D table for each axis, the mean of both directions (its corrections
/// are the same from both). General knowledge, tried on no controller.
ControllerFile aerotech_file(const ControllerTables& tables, const std::string& name);

/// What a table leaves of a correction, of `who`: "drive 1".
std::string left_in_words(const std::string& who, const TableError& before, const TableError& left,
                          const TableError& grid, double step_mm);
/// Directions of approach that need corrections `gap_mm` apart, where a table has one for both;
/// nothing where that is less than the figures show.
std::optional<std::string> sides_in_words(const std::string& who, double gap_mm);
/// Head of an Aerotech file: what it holds, and how far to trust its form.
std::string aerotech_head(const std::string& what);

/// What a table can't carry and what it leaves, a sentence each.
std::vector<std::string> table_words(const ControllerTables& tables, bool both_directions);

}  // namespace trammel::job

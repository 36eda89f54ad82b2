#pragma once
// Tables of commanded and measured positions, as makers of stages and interferometers write them:
// a grid of an XY stage, the runs of an axis.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"

namespace trammel {

struct PositionRow {
  int line = 0;       // from 1
  Pose target;        // coordinates that the file has not are 0
  Pose measured;      // of a file with deviations: target + deviation
  int direction = 0;  // in which the axis arrived: +1, -1; 0: the file does not say
  int run = 0;        // from 1; 0: the file does not say
  std::optional<double> time_s = {};
  std::optional<double> temp_degc = {};
};

struct PositionsFile {
  std::string name;    // the file, as errors show it
  std::string format;  // as it is called: "table", "Aerotech calibration", "Renishaw RTL"
  Coordinates targeted = {}, measured = {};
  std::vector<PositionRow> rows = {};
  std::map<std::string, std::string> facts = {};  // what its header says of machine and measurement
  std::vector<std::string> unused = {};           // columns that nothing here reads
  int missed = 0;                                 // rows of nodes without a measured position
};

struct PositionsOptions {
  std::string unit = {};  // of lengths where the file states none: mm, m, um, in
  std::string axis = {};  // of several axes in one table: this one alone
  bool one_axis = false;  // columns without a coordinate's name are x
  std::string runs = {};  // RTL: "one-way", or "both-ways": every second run comes back
};

inline constexpr std::size_t kMaxPositionsBytes = 64u << 20;

/// Reads a table with a header line (as parse_csv takes it) whose columns name, in any order of
/// words, a role (nominal, target, commanded; measured, actual, position; error, deviation, dx), a
/// coordinate (x, y, phi) and a unit (mm, um, m, in; deg, rad, mrad, urad, arcsec); also run,
/// direction (1, -1, +, -, up, down, forward, reverse), axis, time_s, temp_degc. A bare x is the
/// target beside deviations or what was measured, and the measured one beside a target. Where the
/// comma does not part the columns it may be the decimal sign. A row with nothing in its measured
/// columns is a node that was missed.
/// An Aerotech calibration file: % lines of a header (Ax1Name, UserUnits), then Ax1TestLoc
/// Ax2TestLoc Ax1CmdPos Ax2CmdPos Ax1RelErr Ax2RelErr; an error is taken as measured less
/// commanded. Renishaw's RTL, from general knowledge of it and not from its maker's description:
/// sections "TARGET DATA::" (Target-count, Targets), "RUNS::", "DEVIATIONS::" with run, target's
/// number, deviation. Targets are in mm; of deviations programs differ, and options.unit is needed.
/// Throws InputError with line and column for what is missing, has two readings or is no number.
/// Proof: positions_file_test.cpp.
PositionsFile read_positions(const std::filesystem::path& path, const PositionsOptions& options);
PositionsFile parse_positions(std::string text, const std::string& name,
                              const PositionsOptions& options);

}  // namespace trammel

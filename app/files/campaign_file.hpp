#pragma once
// campaign/2: a folder with campaign.json and readings.csv, read and written without loss;
// campaign/1 is read.

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/files/files.hpp"
#include "core/measure/reading.hpp"
#include "core/measure/screen.hpp"

namespace trammel {

/// A walk that readings belong to.
struct FileSession {
  std::string name = "import";
  std::string compensation = {};  // under which correction; empty: baseline
  std::string plan = {};
  int n_points = 0;                   // that it was to have; 0: not known
  std::vector<int> held_epochs = {};  // in which reference points were found again
};

/// A campaign as the format holds it: the columns x_… are nobody's here, kept and exported again.
struct CampaignFile {
  int format = 2;
  Campaign campaign;
  std::vector<FileSession> sessions = {{}};
  std::vector<std::size_t> session_of = {};  // by reading: place in `sessions`; empty: the first
  std::vector<std::string> roles = {};       // by reading: "circle 1"; empty: none has one
  std::vector<std::pair<int, std::string>> exclusions = {};  // seq and reason
  std::vector<std::string> extra_columns;                    // "x_…", as they stood
  std::vector<std::map<std::string, std::string>> extras;    // by reading; empty cells left out
};

/// Reads a folder that holds campaign.json, or that file by name; "readings" is relative to it.
/// Default of `from` is the previous row's command, home for the first row; of `set` identify, of
/// `epoch` 1. Readings come back by seq.
/// Refused, with file, line, column and field (InputError): unknown columns and fields, text, NaN,
/// infinity or hexadecimal in a number, a missing field, a repeated seq, a measured pose in a
/// predict row or none elsewhere, a target or command out of reach. A measured pose far off is
/// data. NotFoundError: a missing file. Proof: campaign_file_test.cpp.
CampaignFile read_campaign(const std::filesystem::path& folder_or_file);

/// The readings that a calibration takes: of baseline walks, less reference visits and exclusions.
Campaign baseline_of(const CampaignFile& file);

/// What the screen finds in it: in its baseline, and in each walk under a correction.
std::vector<Suspicion> screened(const CampaignFile& file);

/// Pairs of epochs between which reference points were found where they had been.
std::vector<std::pair<int, int>> held_epochs_of(const CampaignFile& file);

/// Writes campaign.json and readings.csv into `folder`, which is made when missing: each file under
/// a temporary name first, the readings before the campaign that names them. Reading it back gives
/// the same numbers, bit for bit; angles leave as the degrees they came in. Files that are there
/// already: write_output.
void write_campaign(const CampaignFile& file, const std::filesystem::path& folder,
                    Existing existing = Existing::refuse);

}  // namespace trammel

#pragma once
// campaign/1: a folder with campaign.json and readings.csv, read and written without loss.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/files/files.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

/// A campaign as the format holds it: the columns x_… are nobody's here, kept and exported again.
struct CampaignFile {
  Campaign campaign;
  std::vector<std::string> extra_columns;                  // "x_…", as they stood
  std::vector<std::map<std::string, std::string>> extras;  // by reading; empty cells left out
};

/// Reads a folder that holds campaign.json, or that file by name; "readings" is relative to it.
/// Default of `from` is the previous row's command, home for the first row; of `set` identify, of
/// `epoch` 1. Readings come back by seq.
/// Refused, with file, line, column and field (InputError): unknown columns and fields, text, NaN,
/// infinity or hexadecimal in a number, a missing field, a repeated seq, a measured pose in a
/// predict row or none elsewhere, a target or command out of reach. A measured pose far off is
/// data. NotFoundError: a missing file. Proof: campaign_file_test.cpp.
CampaignFile read_campaign(const std::filesystem::path& folder_or_file);

/// Writes campaign.json and readings.csv into `folder`, which is made when missing: each file under
/// a temporary name first, the readings before the campaign that names them. Reading it back gives
/// the same numbers, bit for bit; angles leave as the degrees they came in. Files that are there
/// already: write_output.
void write_campaign(const CampaignFile& file, const std::filesystem::path& folder,
                    Existing existing = Existing::refuse);

}  // namespace trammel

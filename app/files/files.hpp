#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace trammel {

/// The whole file. Throws NotFoundError when it is missing, InputError when it is a folder, can't
/// be read or is larger than `max_bytes`.
std::string read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// Writes under a temporary name in the same folder, syncs, renames, syncs the folder: after a
/// crash the file is the old one or the new one, never half of it. Throws StoreError.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// Adds `line` and a newline, and syncs: on the disk when this has returned. Throws StoreError.
void append_line_durably(const std::filesystem::path& path, std::string_view line);

}  // namespace trammel

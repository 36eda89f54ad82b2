#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace trammel {

/// The whole file. Throws NotFoundError when it is missing, InputError when it is a folder, can't
/// be read or is larger than `max_bytes`, and for a pipe into which nobody writes for 2 s, or who
/// holds its other end nothing for a minute. Proof: input_test.cpp.
std::string read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// What becomes of a file that is there already.
enum class Existing { refuse, replace };

/// The one door through which output leaves into files. Writes under a temporary name in the same
/// folder, syncs, renames, syncs the folder: after a crash the file is the old one or the new one,
/// never half of it. The umask holds, a file that is replaced keeps its mode, a symbolic link stays
/// and its target is written; what is no regular file (a device, a pipe) is written through.
///
/// An existing file is refused unless `existing` is `replace` (--overwrite), and then too where it
/// is a database or a journal of one, or is of another format than `content`: JSON of another
/// "schema" or "format", a page, a table. Throws InputError for what is refused, StoreError where
/// the system does. Proof: output_test.cpp.
void write_output(const std::filesystem::path& path, std::string_view content, Existing existing);

/// Makes the file where it is not there, and takes so many bytes of the disk for it, so that what
/// is added later finds room on a disk that has become full. Its size is what it was. On a file
/// system that can't, it is made and no more. Throws StoreError where there is no room now.
void reserve_room(const std::filesystem::path& path, std::size_t n_bytes);

/// Adds `line` and a newline, and syncs: on the disk when this has returned. Throws StoreError.
void append_line_durably(const std::filesystem::path& path, std::string_view line);

}  // namespace trammel

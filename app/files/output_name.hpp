#pragma once

#include "app/files/files.hpp"

namespace trammel {

/// Throws what write_output would throw of the name alone: before work is done for it.
void require_free(const std::filesystem::path& path, Existing existing);

}  // namespace trammel

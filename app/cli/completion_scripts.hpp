#pragma once
// app/cli/completion/trammel.{bash,zsh,fish} as they are in the tree, embedded at build.

#include <string_view>

namespace trammel::cli {

extern const std::string_view kBashCompletion, kZshCompletion, kFishCompletion;

}  // namespace trammel::cli

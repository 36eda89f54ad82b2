#pragma once
// examples/paper, compiled in, so that the demo runs from anywhere.

#include <string_view>

namespace trammel::cli {

extern const std::string_view kPaperRobot;
extern const std::string_view kPaperProtocol;

}  // namespace trammel::cli

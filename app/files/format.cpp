#include "app/files/format.hpp"

namespace trammel {

void take_format(Fields& top, std::string_view expected, std::string_view name) {
  constexpr const char* kFormats =
      "campaign/2, layout/1, protocol/1, machine/1, robot/1, stage/1, tracker/1, "
      "emulated-tracker/1, model/1; "
      "of plans \"schema\": trammel/plan/1";
  const bool there = top.has(name);
  if (there && top.value().at(std::string(name)) == std::string(expected)) return;
  top.refuse(name,
             there ? "the file is not of the format that is read here"
                   : "the file does not say what it is: " + std::string(name) + " is missing",
             "\"" + std::string(name) + "\": \"" + std::string(expected) + "\" (formats are " +
                 kFormats + ")",
             "`trammel template` writes a file of each to start from");
}

}  // namespace trammel

#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

struct ManOptions {
  Command app;
};

/// `man`: the manual page, made from the tree of commands.
void setup_man(Command app, Context& context);
ExitCode run_man(const ManOptions& options, Context& context);

/// trammel(1) as source for groff's man macros. Proof: man_test.cpp (groff -ww finds no fault).
std::string man_page(Command app);

}  // namespace trammel::cli

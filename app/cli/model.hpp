#pragma once

#include <memory>
#include <string>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// `model list|show|diff|predict|export`: the versions of a campaign's model, and what they are
/// for.
void setup_model(Command app, Context& context);

/// `model predict` and `model export` (model_use.cpp).
void setup_model_use(Command model, Context& context);

}  // namespace trammel::cli

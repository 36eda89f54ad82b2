#pragma once

#include "app/session/session.hpp"
#include "store/campaign.hpp"

namespace trammel::session {

/// Whether a stored session is what `request` asks for: the same points in the same order, the same
/// correction (by the key of its job), the same virtual robot. Throws InputError that names what
/// differs, so that nothing measured otherwise passes for what is asked. A real stage is not
/// touched. Proof: agreement_test.cpp.
void require_same(store::Connection& connection, const store::SessionRow& stored,
                  const Request& request);

}  // namespace trammel::session

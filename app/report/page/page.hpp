#pragma once
// A report as a page: one file that needs nothing else.

#include <string>
#include <string_view>
#include <vector>

#include "app/report/gather.hpp"
#include "app/report/page/item.hpp"
#include "store/campaign.hpp"

namespace trammel::report {

/// The page's data, "trammel/report-page/1" (schemas/report-page.schema.json): sections with
/// figures and tables, in order; where the report has a tolerance, a section on whether it is met.
/// Proof: page_test.cpp.
Json page_json(store::Connection& connection, const store::CampaignRow& campaign,
               const Gathered& gathered);

/// The page: style, script and data in one file that asks nobody for anything. A
/// content-security-policy names style and script by their SHA-256, so that nothing else runs
/// whatever names and texts hold. With "live": {"status", "page"}, two addresses beside the page's
/// own, it shows the status on top and asks for both again (serve/server.hpp). Proof: in a browser,
/// with hostile names (page_test.mjs).
std::string page_html(const Json& page);

/// `json` with all its texts as terminal::printable, their lines and tabs kept.
Json printable_texts(Json json);

/// A library that the page's script is bundled with. The terms are bytes of the program.
struct PageLibrary {
  std::string name, version;
  std::string_view terms;
};
std::vector<PageLibrary> page_libraries();

/// `json` as text that stands inside a script element: '<', '>', '&' and the line separators U+2028
/// and U+2029 as \u escapes.
std::string script_json(const Json& json);

}  // namespace trammel::report

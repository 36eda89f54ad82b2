#include "app/report/dcc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "app/report/measured.hpp"
#include "app/report/print.hpp"
#include "store/provenance.hpp"

namespace trammel::report {

namespace {

/// Text of an element: no markup of its own, and no character that XML 1.0 forbids.
std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else {
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  // What is no UTF-8 becomes U+FFFD on its way through JSON.
  using nlohmann::json;
  return json::parse(json(out).dump(-1, ' ', false, json::error_handler_t::replace));
}

/// Elements inside each other: <dcc:name><dcc:content lang="en">text</…></…>.
std::string element(const std::string& name, const std::string& inside) {
  return fmt::format("<dcc:{0}>{1}</dcc:{0}>\n", name, inside);
}
/// What stands in one is not empty, and has no blank around it (DCC's notEmptyStringType).
std::string leaf(const std::string& name, const std::string& text) {
  const std::string inside = xml_text(text);
  const std::size_t first = inside.find_first_not_of(' ');
  if (first == std::string::npos) return element(name, "not stated");
  return element(name, inside.substr(first, inside.find_last_not_of(' ') + 1 - first));
}
std::string content(const std::string& text) {
  return fmt::format("<dcc:content lang=\"en\">{}</dcc:content>", xml_text(text));
}
std::string named(const std::string& name, const std::string& text) {
  return element(name, content(text));
}

std::string millimetres(double value_mm) {
  return fmt::format("<si:value>{:.6f}</si:value><si:unit>\\milli\\metre</si:unit>", value_mm);
}

std::string quantity(const std::string& name, const std::string& inside) {
  return "<dcc:quantity>" + named("name", name) + "<si:real>" + inside +
         "</si:real></dcc:quantity>\n";
}

std::string with_U(const JudgedPoint& p) {
  if (!p.U_mm) return millimetres(p.error_mm);
  return millimetres(p.error_mm) +
         fmt::format(
             "<si:measurementUncertaintyUnivariate><si:expandedMU><si:valueExpandedMU>{:.6f}"
             "</si:valueExpandedMU><si:coverageFactor>2</si:coverageFactor>"
             "<si:coverageProbability>0.95</si:coverageProbability></si:expandedMU>"
             "</si:measurementUncertaintyUnivariate>",
             *p.U_mm);
}

std::string fact(const Report& report, const std::string& key) {
  const auto at = std::ranges::find(report.facts, key, [](const auto& f) { return f.first; });
  return at == report.facts.end() ? "not stated" : at->second;
}

/// ISO 3166-1; ZZ, which that standard leaves to its users, where none is stated.
std::string country_code(const Report& report) {
  const std::string code = fact(report, "country");
  const auto is_capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  return code.size() == 2 && std::ranges::all_of(code, is_capital) ? code : "ZZ";
}

/// The days on which the first and the last session began, UTC; of the campaign without one.
std::pair<std::string, std::string> days_of(const Measured& measured,
                                            const store::CampaignRow& campaign) {
  std::vector<std::string> days;
  for (const Walk& walk : measured.walks) days.push_back(walk.session.created_utc.substr(0, 10));
  if (days.empty()) days.push_back(campaign.created_utc.substr(0, 10));
  const auto [first, last] = std::ranges::minmax(days);
  return {first, last};
}

std::string administrative(const store::CampaignRow& campaign, const Report& report,
                           const Measured& measured) {
  const auto [first_day, last_day] = days_of(measured, campaign);
  const std::string software =
      named("name", "Trammel") + leaf("release", store::this_program().tool_version);
  const std::string core =
      leaf("countryCodeISO3166_1", country_code(report)) + leaf("usedLangCodeISO639_1", "en") +
      leaf("mandatoryLangCodeISO639_1", "en") +
      leaf("uniqueIdentifier", campaign.uuid + "-" + report.chain_head.substr(0, 16)) +
      leaf("beginPerformanceDate", first_day) + leaf("endPerformanceDate", last_day) +
      leaf("performanceLocation", "laboratory");
  const std::string item =
      named("name", report.mechanism) +
      element("identifications", element("identification", leaf("issuer", "customer") +
                                                               leaf("value", report.campaign) +
                                                               named("name", "campaign")));
  const auto contact = [](const std::string& who) {
    return element("contact", named("name", who) + element("location", leaf("city", "not stated")));
  };
  return element(
      "administrativeData",
      "\n" + element("dccSoftware", element("software", software)) + element("coreData", core) +
          element("items", element("item", item)) +
          element("calibrationLaboratory", contact(fact(report, "laboratory"))) +
          element(
              "respPersons",
              element("respPerson", element("person", named("name", fact(report, "operator"))))) +
          element("customer", named("name", fact(report, "customer")) +
                                  element("location", leaf("city", "not stated"))) +
          element("statements",
                  element("statement",
                          named("declaration",
                                report.simulated
                                    ? "SIMULATED: these readings were made by a program, and "
                                      "certify nothing."
                                    : "Readings and calculations are sealed by the identifier's "
                                      "SHA-256 over all readings."))));
}

/// Between which temperatures it was measured, where that was recorded.
std::string conditions(const Measured& measured) {
  std::vector<double> temp_degc;
  for (const Reading& r : measured.campaign.readings) {
    if (r.conditions.temp_degc) temp_degc.push_back(*r.conditions.temp_degc);
  }
  if (temp_degc.empty()) {
    return element(
        "influenceConditions",
        element("influenceCondition",
                named("name", "temperature") +
                    element("data", named("text", "The temperature was not recorded."))));
  }
  const auto [low, high] = std::ranges::minmax_element(temp_degc);
  std::string data;
  for (const auto& [name, value] : {std::pair{"lowest", *low}, {"highest", *high}}) {
    data += quantity(
        fmt::format("{} temperature of the machine", name),
        fmt::format("<si:value>{:.2f}</si:value><si:unit>\\degreecelsius</si:unit>", value));
  }
  return element(
      "influenceConditions",
      element("influenceCondition", named("name", "temperature") + element("data", "\n" + data)));
}

std::string results(const JudgedPoints& points, std::span<const BudgetRow> rows) {
  std::string errors;
  for (const JudgedPoint& p : points.points) {
    errors += quantity(fmt::format("position error at x {:.3f} mm, y {:.3f} mm", p.x_mm, p.y_mm),
                       with_U(p));
  }
  std::string budget =
      quantity("standard uncertainty of a reading", millimetres(points.u_reading_mm));
  for (const BudgetRow& row : rows) {
    budget += quantity(fmt::format("{} ({}, {})", row.name, row.distribution, row.source),
                       millimetres(row.contribution_mm()));
  }
  const auto result = [](const std::string& name, const std::string& data) {
    return element("result", named("name", name) + element("data", "\n" + data));
  };
  return element(
      "results",
      "\n" + result("Position errors", errors) +
          result("Budget of U, standard uncertainties of a coordinate: " + points.U_from, budget));
}

}  // namespace

std::string dcc_xml(store::Connection& connection, const store::CampaignRow& campaign,
                    const Report& report, const JudgedPoints& points) {
  const Measured measured = load_measured(connection, campaign);
  const std::string instrument =
      element("measuringEquipments",
              element("measuringEquipment", named("name", fact(report, "instrument")) +
                                                named("description", report.noise)));
  const std::string method = element(
      "usedMethods",
      element("usedMethod",
              named("name", "Distances of measured poses from their targets") +
                  named("description", whose_words(points) + "; session " + points.session)));
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<dcc:digitalCalibrationCertificate xmlns:dcc=\"https://ptb.de/dcc\" "
         "xmlns:si=\"https://ptb.de/si\" schemaVersion=\"3.3.0\">\n" +
         administrative(campaign, report, measured) +
         element("measurementResults",
                 "\n" + element("measurementResult",
                                "\n" + named("name", verdict(report)) + method + instrument +
                                    conditions(measured) + results(points, report.budget))) +
         "</dcc:digitalCalibrationCertificate>\n";
}

}  // namespace trammel::report

// Raw facts: instrument, conditions, order, versions, keys, exclusions, the end of the chain.

#include <fmt/format.h>

#include <algorithm>

#include "app/job/text.hpp"
#include "app/report/page/source.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

std::string range_words(const std::vector<double>& values, const char* format_each) {
  if (values.empty()) return "not recorded";
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return fmt::format(fmt::runtime(format_each), *low) + " to " +
         fmt::format(fmt::runtime(format_each), *high);
}

Json session_row(const SessionRow& row, const Walk& walk) {
  std::vector<double> times_h, temperatures_degc;
  int first = 0, last = 0;
  for (const Visit& v : walk.visits) {
    const Conditions& c = v.reading.conditions;
    if (c.time_s) times_h.push_back(*c.time_s / kSecondsPerHour);
    if (c.temp_degc) temperatures_degc.push_back(*c.temp_degc);
    if (first == 0) first = v.reading.seq;
    last = v.reading.seq;
  }
  return Json::array({row.name, row.plan, row.compensation.empty() ? "baseline" : row.compensation,
                      std::to_string(row.n_points), std::to_string(row.n_readings),
                      std::to_string(row.n_epochs), fmt::format("{} to {}", first, last),
                      range_words(times_h, "{:.2f}"), range_words(temperatures_degc, "{:.2f}"),
                      walk.session.stage, walk.session.tracker, walk.session.created_utc});
}

Json job_row(const store::Job& job) {
  return Json::array(
      {std::to_string(job.id), job.data.stage, std::to_string(job.data.algorithm_version),
       job::parameter_words(job.data.parameters_json), std::to_string(job.data.n_readings),
       job.data.key.key, job.created_utc,
       fmt::format("{} ({}), {}, {}, {}", job.provenance.tool_version, job.provenance.git_revision,
                   job.provenance.compiler, job.provenance.libraries, job.provenance.cpu_level)});
}

Json temperature_figure(const Source& source) {
  const char* title = "Temperature over the campaign";
  Json sessions = Json::array();
  for (const Walk& walk : source.measured.walks) {
    Json points = Json::array();
    for (const Visit& v : walk.visits) {
      const Conditions& c = v.reading.conditions;
      if (!c.temp_degc || !c.time_s) continue;
      points.push_back(Json::array({drawn(*c.time_s / kSecondsPerHour), drawn(*c.temp_degc)}));
    }
    if (!points.empty()) sessions.push_back({{"name", walk.session.name}, {"points", points}});
  }
  if (sessions.empty()) {
    return absent("temperature", title, "Temperature or time of the readings was not recorded.");
  }
  return figure(
      {"temperature", title,
       "Temperature of the machine [degC] as recorded with each reading, by hours since the "
       "campaign's start; one colour a session."},
      "temperature", {{"sessions", sessions}});
}

Json identification_table(const Source& source) {
  const auto& found = source.report.identification;
  const char* title = "Identified error sources";
  if (!found)
    return absent("identified", title, "No least squares: trammel calibrate lsq CAMPAIGN.");
  Json rows = Json::array();
  for (const auto* all : {&found->parameters, &found->combinations}) {
    for (const ParameterRow& p : *all) {
      rows.push_back(
          Json::array({p.epoch > 1 ? fmt::format("{} (epoch {})", p.name, p.epoch) : p.name,
                       p.identified ? fmt::format("{:.4f}", p.value)
                                    : (p.dropped ? "dropped" : "not by itself"),
                       p.identified ? fmt::format("{:.4f}", 2 * p.standard_uncertainty) : "-",
                       p.unit, p.paper ? fmt::format("{:.4f}", *p.paper) : "-"}));
    }
  }
  return table_beside_paper(source,
                            {"identified", title,
                             fmt::format("Change from nominal, in-sample; rank {} of {} columns; "
                                         "residuals are {:.1f} times the noise",
                                         found->rank, found->columns, found->sigma_ratio)},
                            {"parameter", "value", "U (k = 2)", "unit", "the paper"}, rows);
}

Json campaign_table(const Source& source) {
  const Report& report = source.report;
  Json rows = Json::array(
      {Json::array({"campaign", report.campaign}), Json::array({"uuid", source.campaign.uuid}),
       Json::array({"kind", std::string(report.simulated ? "SIMULATED" : "real") +
                                (report.imported ? ", imported" : "")}),
       Json::array({"created", source.campaign.created_utc}),
       Json::array({"mechanism", report.mechanism}), Json::array({"noise", report.noise}),
       Json::array({"readings",
                    fmt::format("{} used, {} excluded", report.n_readings, report.n_excluded)})});
  for (const auto& [key, value] : report.facts) rows.push_back(Json::array({key, value}));
  rows.push_back(Json::array({"SHA-256 over all readings", report.chain_head}));
  if (report.taken_over) {
    rows.push_back(Json::array({fmt::format("SHA-256 in the database of version {} before",
                                            report.taken_over->from_version),
                                report.taken_over->head}));
  }
  return table({"campaign", "Campaign and instrument", ""}, {"fact", "value"}, rows);
}

}  // namespace

Json facts_section(const Source& source) {
  Json items = Json::array({campaign_table(source)});
  Json sessions = Json::array(), jobs = Json::array(), exclusions = Json::array();
  for (std::size_t k = 0; k < source.report.sessions.size(); ++k) {
    sessions.push_back(session_row(source.report.sessions[k], source.measured.walks[k]));
  }
  for (const JobRow& row : source.report.jobs) {
    jobs.push_back(job_row(store::get_job(source.connection, row.id)));
  }
  for (const std::string& line : source.report.exclusions)
    exclusions.push_back(Json::array({line}));
  items.push_back(table({"sessions", "Sessions, in the order of measurement", ""},
                        {"session", "plan", "compensation", "points", "readings", "epochs", "seq",
                         "time [h]", "temperature [degC]", "stage", "tracker", "created (UTC)"},
                        sessions));
  items.push_back(temperature_figure(source));
  items.push_back(jobs.empty() ? absent("jobs", "Jobs", "No calibration was made yet.")
                               : table({"jobs", "Jobs", ""},
                                       {"job", "stage", "version", "parameters", "readings", "key",
                                        "created (UTC)", "made by"},
                                       jobs));
  items.push_back(identification_table(source));
  items.push_back(
      exclusions.empty()
          ? absent("exclusions", "Exclusions", "No reading was left out.")
          : table({"exclusions", "Exclusions", ""}, {"reading and reason"}, exclusions));
  return section("facts", "Raw facts", items);
}

}  // namespace trammel::report

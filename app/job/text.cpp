#include "app/job/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "app/job/contest_text.hpp"
#include "app/job/identification.hpp"
#include "app/job/run.hpp"
#include "app/terminal/counted.hpp"
#include "core/statistics/summary.hpp"

namespace trammel::job {

namespace {

constexpr std::string_view kNothingHeldOut = "nothing of these readings is held out";

std::optional<double> improvement(const store::Statistic& s) {
  if (!s.before || !s.after || s.set == kNewEpoch) return std::nullopt;
  return improvement_pct({.mean = s.before->mean}, {.mean = s.after->mean});
}

Json summary_json(const std::optional<store::Summary>& s) {
  if (!s) return nullptr;
  return {{"mean", s->mean}, {"max", s->max}, {"min", s->min}, {"p95", s->p95}, {"n", s->n}};
}

std::string cells(const std::optional<store::Summary>& s) {
  if (!s) return fmt::format("{:>9}{:>9}{:>9}", "-", "-", "-");
  const int decimals = s->max < 0.01 ? 6 : 4;  // micrometres in mm
  return fmt::format("{:9.{}f}{:9.{}f}{:9.{}f}", s->mean, decimals, s->p95, decimals, s->max,
                     decimals);
}

}  // namespace

std::string campaign_title(const std::string& name, bool simulated) {
  return simulated ? name + " (SIMULATED)" : name;
}

std::string kind_text(bool simulated) { return simulated ? "simulated" : "real"; }

std::string parameter_words(const std::string& parameters_json) {
  const auto plain = [](const Json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
  };
  std::string text;
  const Json parameters = Json::parse(parameters_json);
  for (const auto& [name, value] : parameters.items()) {
    std::string words;
    if (value.is_array()) {
      for (const Json& each : value) words += (words.empty() ? "" : " + ") + plain(each);
    } else if (value.is_boolean()) {
      words = value.get<bool>() ? "yes" : "no";
    } else {
      words = plain(value);
    }
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, words.empty() ? "none" : words);
  }
  return text.empty() ? "none" : text;
}

bool is_of_no_held_out(std::string_view sentence) { return sentence.starts_with(kNothingHeldOut); }

bool is_warning(std::string_view sentence) {
  constexpr std::string_view kSigns[] = {
      "warning: ",
      "absorption alarm",
      "not tested: ",                     // absorption by halves
      "more than noise alone leaves (",   // residuals
      "no degrees of freedom are left",   // so nothing tells whether the model is right
      "do not belong to the rest",        // outlying readings
      "the end of the grid",              // a network's spread
      kNothingHeldOut,                    // in-sample figures alone
      "the fit follows the noise",        // below the floor
      "no diagnosis: ",                   // a contest without named effects
      "since nothing could be held out",  // a map that was left out for that
  };
  return std::ranges::any_of(kSigns, [sentence](std::string_view sign) {
    return sentence.find(sign) != std::string_view::npos;
  });
}

Json statistics_json(const std::vector<store::Statistic>& statistics) {
  Json all = Json::array();
  for (const store::Statistic& s : statistics) {
    const auto gain = improvement(s);
    all.push_back({{"set", s.set},
                   {"metric", s.metric},
                   {"in_sample", s.in_sample},
                   {"before", summary_json(s.before)},
                   {"after", summary_json(s.after)},
                   {"improvement_pct", gain ? Json(*gain) : Json()}});
  }
  return all;
}

std::string statistics_text(const std::vector<store::Statistic>& statistics) {
  std::string text =
      fmt::format("  {:<38}{:>5}   {:>24}   {:>24}{:>9}\n", "predicted after compensation", "n",
                  "before: mean  p95  max", "after: mean  p95  max", "gain");
  for (const store::Statistic& s : statistics) {
    const auto gain = improvement(s);
    const int n = s.before ? s.before->n : s.after ? s.after->n : 0;
    text += fmt::format("  {:<38}{:>5}{}{}{:>9}\n",
                        fmt::format("{} {} ({})", s.set, s.metric,
                                    s.set == kNewEpoch ? "not judged"
                                    : s.in_sample      ? "in-sample"
                                                       : "held-out"),
                        n, cells(s.before), cells(s.after),
                        gain ? fmt::format("{:.1f} %", *gain) : "-");
  }
  return text;
}

Json job_json(const store::Job& job, const store::CampaignRow& campaign) {
  const Json result = Json::parse(job.data.result_json);
  return {{"id", job.id},
          {"key", job.data.key.key},
          {"run", job.run},
          {"campaign", campaign.name},
          {"kind", kind_text(campaign.simulated)},
          {"stage", job.data.stage},
          {"algorithm_version", job.data.algorithm_version},
          {"parameters", Json::parse(job.data.parameters_json)},
          {"readings", job.data.n_readings},
          {"exclusions", job.data.exclusions.size()},
          {"after", result.value("after", "")},
          {"statistics", statistics_json(job.data.statistics)},
          {"words", result.value("words", Json::array())},
          {"details", result.value("details", Json::object())},
          {"created_utc", job.created_utc},
          {"duration_s", job.data.duration_s},
          {"tool_version", job.provenance.tool_version},
          {"git_revision", job.provenance.git_revision},
          {"compiler", job.provenance.compiler},
          {"libraries", job.provenance.libraries},
          {"cpu_level", job.provenance.cpu_level}};
}

std::string job_text(const store::Job& job, const store::CampaignRow& campaign) {
  const Json result = Json::parse(job.data.result_json);
  const std::string name = job.id == 0 ? "not stored" : fmt::format("job {}", job.id);
  std::string text = fmt::format(
      "{}: {} {} of {} of {}{}, key {}\n", name, job.data.stage, job.data.parameters_json,
      terminal::counted(job.data.n_readings, "reading"),
      campaign_title(campaign.name, campaign.simulated),
      job.run > 1 ? fmt::format(", run {}", job.run) : "", job.data.key.key.substr(0, 12));
  const Json details = result.value("details", Json::object());
  text += contest_table(details, result.value("timing", Json::object()));
  for (const Json& sentence : result.value("words", Json::array())) {
    text += "  " + sentence.get<std::string>() + "\n";
  }
  return text + identified_table(details) + statistics_text(job.data.statistics);
}

}  // namespace trammel::job

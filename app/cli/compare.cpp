#include "app/cli/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/job/text.hpp"
#include "app/report/gather.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

using report::ErrorTable;
using report::Report;

struct Common {
  ErrorTable a, b;
};

std::vector<Common> common_tables(const Report& a, const Report& b) {
  std::vector<Common> common;
  for (const ErrorTable& table : a.tables) {
    const auto same = std::find_if(b.tables.begin(), b.tables.end(), [&table](const ErrorTable& t) {
      return t.id == table.id && t.standing == table.standing;
    });
    if (same != b.tables.end()) common.push_back({table, *same});
  }
  return common;
}

Json side_json(const ErrorTable& table) {
  return {{"n", table.before.n},
          {"before_mean", table.before.mean},
          {"after_mean", table.after.mean},
          {"after_is", table.after_predicted ? "predicted" : "measured"}};
}

Json to_json(const Report& a, const Report& b, const std::vector<Common>& common) {
  Json json = {{"a", a.campaign},
               {"a_kind", job::kind_text(a.simulated)},
               {"b", b.campaign},
               {"b_kind", job::kind_text(b.simulated)},
               {"tables", Json::array()}};
  for (const Common& c : common) {
    json["tables"].push_back({{"id", c.a.id},
                              {"unit", c.a.unit},
                              {"in_sample", c.a.in_sample()},
                              {"judged", name_of(c.a.standing)},
                              {"a", side_json(c.a)},
                              {"b", side_json(c.b)},
                              {"after_mean_difference", c.b.after.mean - c.a.after.mean}});
  }
  return json;
}

std::string title(const Report& report) {
  return job::campaign_title(printable(report.campaign), report.simulated);
}

std::string to_text(const Report& a, const Report& b, const std::vector<Common>& common) {
  if (common.empty()) {
    return "no figure in common: calibrate both campaigns by the same method on the same points";
  }
  std::string text = fmt::format(
      "A {}\nB {}\nmean errors, * predicted\n\n{:<20} {:<10} {:<4} {:>8} {:>9} {:>8} {:>9} {:>9}\n",
      title(a), title(b), "figure", "judged", "unit", "A before", "A after", "B before", "B after",
      "B - A");
  for (const Common& c : common) {
    const int decimals = std::max(c.a.decimals, c.b.decimals);
    const auto after = [decimals](const ErrorTable& t) {
      return fmt::format("{:.{}f}{}", t.after.mean, decimals, t.after_predicted ? "*" : " ");
    };
    text +=
        fmt::format("{0:<20} {1:<10} {2:<4} {3:>8.{8}f} {4:>9} {5:>8.{8}f} {6:>9} {7:>+9.{8}f}\n",
                    c.a.id, name_of(c.a.standing), c.a.unit, c.a.before.mean, after(c.a),
                    c.b.before.mean, after(c.b), c.b.after.mean - c.a.after.mean, decimals);
  }
  return text;
}

}  // namespace

ExitCode run_compare(const CompareOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const auto report_of = [&connection](const std::string& name) {
    return report::gather(connection, store::require_campaign(connection, name)).report;
  };
  const Report a = report_of(options.a), b = report_of(options.b);
  const std::vector<Common> common = common_tables(a, b);
  if (context.json) {
    context.print("compare", to_json(a, b, common));
  } else {
    context.print(to_text(a, b, common));
  }
  return ExitCode::ok;
}

void setup_compare(Command app, Context& context) {
  auto options = std::make_shared<CompareOptions>();
  Command command = app.command("compare", "The figures of two campaigns side by side");
  command.option("A", options->a, "Name or uuid").required().type("CAMPAIGN");
  command.option("B", options->b, "Name or uuid").required().type("CAMPAIGN");
  on_run(command, context, options, run_compare);
}

}  // namespace trammel::cli

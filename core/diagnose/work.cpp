#include "core/diagnose/work.hpp"

#include <cstdio>

namespace trammel {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::vector<Reading> of_set(const Campaign& campaign, ReadingSet set) {
  std::vector<Reading> readings;
  for (const Reading& r : campaign.readings) {
    if (r.set == set && (r.measured || set == ReadingSet::predict)) readings.push_back(r);
  }
  return readings;
}

void fit_base(Work& w) {
  const NoiseFloor& noise = w.out.noise;
  if (w.history == nullptr)
    w.history = std::make_shared<History>(w.campaign.machine, w.campaign.readings);
  RobotModel start = nominal_model(w.campaign.machine);
  start.history = w.history;
  w.base = fit_geometry(start, w.readings, noise.sigma(), {.correlation = noise.correlation});
  w.space = residual_space(w.base, w.readings, noise.sigma(), noise.correlation);
  w.library = make_library(w.space);
}

void make_shapes(Work& w, const ResidualSpace& space) {
  w.shapes = dictionary(space);
  for (const Unit& unit : w.library.units) {
    const Effect& effect = effect_catalogue()[static_cast<std::size_t>(unit.effect)];
    Shape shape{"effect " + effect.name, "all", {}};
    shape.columns.resize(space.rows(), static_cast<Eigen::Index>(unit.columns.size()));
    for (std::size_t c = 0; c < unit.columns.size(); ++c) {
      shape.columns.col(static_cast<Eigen::Index>(c)) = w.library.signals.col(unit.columns[c]);
    }
    w.shapes.push_back(std::move(shape));
  }
}

StructureTest test(const Work& w, const ResidualSpace& space, double level) {
  return test_structure(space, w.shapes,
                        {.replicates = w.options.replicates,
                         .level = level,
                         .seed = w.options.seed,
                         .threads = w.options.threads,
                         .exchange = w.out.noise.robust});
}

}  // namespace trammel

#include "core/diagnose/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/units.hpp"

namespace trammel {

namespace {

using Scalar = std::function<double(const Reading&, const Moment&)>;

struct Range {
  double low = 0, high = 0;
  [[nodiscard]] double width() const { return high - low; }
  [[nodiscard]] double unit(double v) const {
    return width() > 0 ? 2 * (v - low) / width() - 1 : 0;
  }
};

std::string text(const char* format, double a, double b = 0) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, format, a, b);
  return buffer;
}

/// Nine regions of the plane: the middle one, the step to its neighbours, and their width.
struct Regions {
  double x_mm = 0, y_mm = 0, step_mm = 65, width_mm = 40;
};

class Builder {
 public:
  explicit Builder(const ResidualSpace& space) : space_(space) {}

  void add(std::string where, std::string when, const std::vector<DeviationOf>& terms) {
    Eigen::MatrixXd columns(space_.rows(), static_cast<Eigen::Index>(terms.size()));
    for (std::size_t k = 0; k < terms.size(); ++k) {
      columns.col(static_cast<Eigen::Index>(k)) = whitened_signal(space_, terms[k]);
    }
    shapes_.push_back({std::move(where), std::move(when), std::move(columns), terms});
  }

  [[nodiscard]] Range range(const Scalar& f) const {
    Range r{INFINITY, -INFINITY};
    for (std::size_t i = 0; i < space_.readings.size(); ++i) {
      const double v = f(space_.readings[i], space_.predictions[i].moment);
      r.low = std::min(r.low, v);
      r.high = std::max(r.high, v);
    }
    return r;
  }

  /// Between two neighbouring values that differ, mm.
  [[nodiscard]] double smallest_gap(const Scalar& f) const {
    constexpr double kOneNodeMm = 1e-3;
    std::vector<double> values;
    for (std::size_t i = 0; i < space_.readings.size(); ++i) {
      values.push_back(f(space_.readings[i], space_.predictions[i].moment));
    }
    std::ranges::sort(values);
    double smallest = INFINITY;
    for (std::size_t i = 1; i < values.size(); ++i) {
      const double gap = values[i] - values[i - 1];
      if (gap > kOneNodeMm) smallest = std::min(smallest, gap);
    }
    return std::isfinite(smallest) ? smallest : 0;
  }

  [[nodiscard]] bool all_have(bool (*has)(const Conditions&)) const {
    return std::all_of(space_.readings.begin(), space_.readings.end(),
                       [&](const Reading& r) { return has(r.conditions); });
  }

  std::vector<Shape> take() { return std::move(shapes_); }

  /// Over what was measured; of a 3-PRR, whose workspace is round, over the paper's.
  [[nodiscard]] Regions regions() const {
    if (space_.machine.kind->chain == &kPrrChain) return {};
    const Range x = range([](const Reading&, const Moment& m) { return m.pose.x_mm; });
    const Range y = range([](const Reading&, const Moment& m) { return m.pose.y_mm; });
    const double step_mm = std::max({x.width(), y.width(), 1e-3}) / 3;
    return {(x.low + x.high) / 2, (y.low + y.high) / 2, step_mm, 40.0 / 65 * step_mm};
  }

  [[nodiscard]] int rails() const { return space_.machine.kind->n_chains; }
  [[nodiscard]] std::string rail_name(int rail) const { return drive_name(space_.machine, rail); }
  [[nodiscard]] std::string guide_name(int rail) const {
    return trammel::guide_name(space_.machine, rail);
  }
  [[nodiscard]] bool has_guides() const {
    return space_.machine.kind->chain->offset && rails() > 1;
  }
  [[nodiscard]] bool has_passive_guides() const {
    return space_.machine.kind->chain->on_guide != nullptr;
  }
  [[nodiscard]] bool has_links() const { return space_.machine.kind->chain != &kPprChain; }
  [[nodiscard]] std::string link() const {
    return space_.machine.kind->chain == &kPrrChain ? "link" : "cylinder";
  }
  [[nodiscard]] std::string all_drives() const { return "all " + drives(); }
  [[nodiscard]] std::string drives() const { return drives_name(*space_.machine.kind); }
  [[nodiscard]] bool is_measured(int coordinate) const { return space_.is_measured(coordinate); }
  [[nodiscard]] double lead_mm(int rail) const {
    return space_.machine.drives[static_cast<std::size_t>(rail)].lead_mm;
  }
  /// "readings in x, y, phi", those that are measured.
  [[nodiscard]] std::string readings_in_all() const {
    std::string text;
    for (std::size_t c = 0; c < kCoordinateNames.size(); ++c) {
      if (!is_measured(static_cast<int>(c))) continue;
      text += (text.empty() ? "readings in " : ", ") + std::string(kCoordinateNames[c]);
    }
    return text;
  }
  /// The same function in every coordinate that is measured.
  [[nodiscard]] std::vector<DeviationOf> in_all_readings(const Scalar& f) const;
  [[nodiscard]] std::vector<DeviationOf> along_all_rails(const Scalar& f) const;

 private:
  const ResidualSpace& space_;
  std::vector<Shape> shapes_;
};

DeviationOf along(int rail, Scalar f) {
  return [rail, f = std::move(f)](const Reading& r, const Moment& m) {
    Deviation d;
    d.dl_mm[rail] = f(r, m);
    return d;
  };
}

DeviationOf across(int rail, Scalar f) {
  return [rail, f = std::move(f)](const Reading& r, const Moment& m) {
    Deviation d;
    d.dh_mm[rail] = f(r, m);
    return d;
  };
}

constexpr double kLeverMm = 100;  // makes a radian count like the millimetres it moves a joint

DeviationOf reading(int coordinate, Scalar f) {
  return [coordinate, f = std::move(f)](const Reading& r, const Moment& m) {
    Deviation d;
    d.dX[coordinate] = f(r, m) * (coordinate == 2 ? 1 / kLeverMm : 1.0);
    return d;
  };
}

std::vector<DeviationOf> Builder::in_all_readings(const Scalar& f) const {
  std::vector<DeviationOf> all;
  for (int c = 0; c < 3; ++c) {
    if (is_measured(c)) all.push_back(reading(c, f));
  }
  return all;
}

std::vector<DeviationOf> Builder::along_all_rails(const Scalar& f) const {
  std::vector<DeviationOf> all;
  for (int rail = 0; rail < rails(); ++rail) all.push_back(along(rail, f));
  return all;
}

double legendre(int degree, double u) {
  double p0 = 1, p1 = u;
  if (degree == 0) return p0;
  for (int n = 1; n < degree; ++n) {
    const double p2 = ((2 * n + 1) * u * p1 - n * p0) / (n + 1);
    p0 = p1;
    p1 = p2;
  }
  return p1;
}

void add_rail_shapes(Builder& builder) {
  for (int rail = 0; rail < builder.rails(); ++rail) {
    const Scalar l = [rail](const Reading&, const Moment& m) { return m.l_mm[rail]; };
    const Range range = builder.range(l);
    const auto power = [=](int degree) -> Scalar {
      return
          [=](const Reading& r, const Moment& m) { return legendre(degree, range.unit(l(r, m))); };
    };
    const Scalar g = [rail](const Reading&, const Moment& m) { return m.guide_mm[rail]; };
    const Range on_guide = builder.range(g);
    const bool passive = builder.has_passive_guides();
    const auto along_guide = [=](int degree) -> Scalar {
      if (!passive) return power(degree);
      return [=](const Reading& r, const Moment& m) {
        return legendre(degree, on_guide.unit(g(r, m)));
      };
    };
    std::vector<DeviationOf> both;
    for (int degree = 1; degree <= 6; ++degree) {
      builder.add(
          builder.rail_name(rail) + ", along it, degree " + std::to_string(degree) + " in l", "all",
          {along(rail, power(degree))});
      if (builder.has_guides()) {
        builder.add(
            builder.guide_name(rail) + ", across it, degree " + std::to_string(degree) + " in l",
            "all", {across(rail, along_guide(degree))});
      }
      both.push_back(along(rail, power(degree)));
    }
    builder.add(builder.rail_name(rail) + ", a smooth curve along it", "all", both);
    const int bumps = 10;
    const double width = range.width() / bumps;
    for (int b = 0; b < bumps; ++b) {
      const double centre = range.low + (b + 0.5) * width;
      const Scalar bump = [=](const Reading& r, const Moment& m) {
        const double u = (l(r, m) - centre) / (0.6 * width);
        return std::exp(-u * u);
      };
      builder.add(builder.rail_name(rail) +
                      text(", l %.0f to %.0f mm", centre - 0.6 * width, centre + 0.6 * width),
                  "all",
                  builder.has_guides() && !passive
                      ? std::vector<DeviationOf>{along(rail, bump), across(rail, bump)}
                      : std::vector<DeviationOf>{along(rail, bump)});
    }
  }
}

/// Periods in leads up to a little more than a turn (harmonics, a lead stated wrong), and besides
/// one per wave that the travelled range holds: no period between two of them is missed.
std::vector<double> periods_mm(double lead_mm, double range_mm) {
  std::vector<double> periods;
  for (const double turns : {0.25, 1.0 / 3, 0.4, 0.5, 0.6, 2.0 / 3, 0.75, 0.9, 0.95, 0.98, 0.99,
                             1.01, 1.02, 1.05, 1.1}) {
    periods.push_back(turns * lead_mm);
  }
  constexpr int kMostWaves = 64;  // shorter ones are sampled too thinly to be told from one another
  constexpr double kSameWave = 0.3;  // waves over the range
  const std::vector<double> of_the_screw = periods;
  for (int waves = 3; waves < kMostWaves; ++waves) {
    const bool known =
        std::any_of(of_the_screw.begin(), of_the_screw.end(),
                    [&](double p) { return std::abs(range_mm / p - waves) < kSameWave; }) ||
        std::abs(range_mm / lead_mm - waves) < kSameWave;
    if (!known) periods.push_back(range_mm / waves);
  }
  return periods;
}

/// Waves shorter than two of the nodes on which a rail was read are, there, longer ones: a stage
/// that was measured every 30 mm says nothing of what repeats every 5.
void add_periodic_shapes(Builder& builder) {
  for (int rail = 0; rail < builder.rails(); ++rail) {
    const Scalar l = [rail](const Reading&, const Moment& m) { return m.l_mm[rail]; };
    const Range range = builder.range(l);
    const double shortest_mm = 2 * builder.smallest_gap(l);
    for (const double period : periods_mm(builder.lead_mm(rail), range.width())) {
      if (period < shortest_mm) continue;
      const auto wave = [=](bool sine) -> Scalar {
        return [=](const Reading&, const Moment& m) {
          const double turn = 2 * kPi * m.l_mm[rail] / period;
          return sine ? std::sin(turn) : std::cos(turn);
        };
      };
      builder.add(builder.rail_name(rail) + text(", repeating every %.2f mm", period), "all",
                  {along(rail, wave(true)), along(rail, wave(false))});
    }
  }
}

void add_direction_shapes(Builder& builder) {
  for (int rail = 0; rail < builder.rails(); ++rail) {
    const auto with = [rail](double (*f)(const Moment&, int)) -> Scalar {
      return [=](const Reading&, const Moment& m) { return m.direction[rail] * f(m, rail); };
    };
    const std::string name = builder.rail_name(rail);
    builder.add(name, "by direction of approach",
                {along(rail, with([](const Moment&, int) { return 1.0; }))});
    if (builder.has_guides()) {
      builder.add(builder.guide_name(rail) + ", across it", "by direction of approach",
                  {across(rail, with([](const Moment&, int) { return 1.0; }))});
    }
    builder.add(name + ", growing with travel", "by direction of approach",
                {along(rail, with([](const Moment& m, int i) { return m.s_mm[i] / kLeverMm; }))});
    builder.add(
        name + ", growing with the square of travel", "by direction of approach",
        {along(rail, with([](const Moment& m, int i) { return m.s_mm[i] * m.s_mm[i] / 1e4; }))});
    builder.add(
        name, "by the length of the last move",
        {along(rail, [rail](const Reading&, const Moment& m) { return m.travel_mm[rail] / 10; }),
         along(rail, [rail](const Reading&, const Moment& m) {
           return std::abs(m.travel_mm[rail]) / 10;
         })});
    for (int other = 0; other < builder.rails(); ++other) {
      if (other == rail) continue;
      builder.add(
          name, "by direction of approach of " + builder.rail_name(other),
          {along(rail, [other](const Reading&, const Moment& m) { return m.direction[other]; })});
    }
  }
  for (int coordinate = 0; coordinate < 3; ++coordinate) {
    if (!builder.is_measured(coordinate)) continue;
    std::vector<DeviationOf> terms;
    for (int rail = 0; rail < builder.rails(); ++rail) {
      terms.push_back(reading(
          coordinate, [rail](const Reading&, const Moment& m) { return m.direction[rail]; }));
    }
    builder.add(std::string("readings in ") + "xyp"[coordinate] + (coordinate == 2 ? "hi" : ""),
                "by direction of approach", terms);
  }
}

void add_temperature_shapes(Builder& builder) {
  if (!builder.all_have([](const Conditions& c) { return c.temp_degc.has_value(); })) return;
  const Scalar T = [](const Reading&, const Moment& m) {
    return *m.temp_degc - kReferenceTemperatureDegc;
  };
  const Range range = builder.range(T);
  if (range.width() <= 0) return;
  const Scalar u = [=](const Reading& r, const Moment& m) { return range.unit(T(r, m)); };
  builder.add("readings", "following the temperature", builder.in_all_readings(u));
  builder.add(builder.all_drives() + ", by a constant", "following the temperature",
              builder.along_all_rails(u));
  builder.add(builder.all_drives() + ", by a constant", "following the square of the temperature",
              builder.along_all_rails(
                  [=](const Reading& r, const Moment& m) { return u(r, m) * u(r, m); }));
  for (int rail = 0; rail < builder.rails(); ++rail) {
    builder.add(builder.rail_name(rail) + ", growing with travel", "following the temperature",
                {along(rail, [=](const Reading& r, const Moment& m) {
                  return u(r, m) * m.s_mm[rail] / kLeverMm;
                })});
    builder.add(builder.rail_name(rail) + ", growing with l",
                "following the square of the temperature",
                {along(rail, [=](const Reading& r, const Moment& m) {
                  return u(r, m) * u(r, m) * m.l_mm[rail] / kLeverMm;
                })});
  }
  builder.add("readings, growing with distance from the centre", "following the temperature",
              {reading(0, [=](const Reading& r,
                              const Moment& m) { return u(r, m) * m.pose.x_mm / kLeverMm; }),
               reading(1, [=](const Reading& r, const Moment& m) {
                 return u(r, m) * m.pose.y_mm / kLeverMm;
               })});
}

void add_time_shapes(Builder& builder) {
  if (!builder.all_have([](const Conditions& c) { return c.time_s.has_value(); })) return;
  const Scalar t = [](const Reading&, const Moment& m) { return *m.time_h; };
  const Range range = builder.range(t);
  if (range.width() <= 0) return;
  const Scalar u = [=](const Reading& r, const Moment& m) { return range.unit(t(r, m)); };
  for (int degree = 1; degree <= 4; ++degree) {
    const Scalar p = [=](const Reading& r, const Moment& m) { return legendre(degree, u(r, m)); };
    builder.add("readings", "a trend of degree " + std::to_string(degree) + " in time",
                builder.in_all_readings(p));
    builder.add(builder.all_drives(), "a trend of degree " + std::to_string(degree) + " in time",
                builder.along_all_rails(p));
  }
  for (int rail = 0; rail < builder.rails(); ++rail) {
    builder.add(builder.rail_name(rail) + ", growing with travel", "in proportion to time",
                {along(rail, [=](const Reading& r, const Moment& m) {
                  return u(r, m) * m.s_mm[rail] / kLeverMm;
                })});
  }
  for (const double hours : {0.1, 0.25, 0.5, 1.0}) {
    const Scalar decay = [=](const Reading& r, const Moment& m) {
      return std::exp(-(t(r, m) - range.low) / hours);
    };
    builder.add("readings", text("settling within %.2g h of the start", hours),
                builder.in_all_readings(decay));
    builder.add(builder.all_drives(), text("settling within %.2g h of the start", hours),
                builder.along_all_rails(decay));
    for (int rail = 0; rail < builder.rails(); ++rail) {
      builder.add(builder.rail_name(rail) + ", growing with l",
                  text("settling within %.2g h of the start", hours),
                  {along(rail, [=](const Reading& r, const Moment& m) {
                    return decay(r, m) * m.l_mm[rail] / kLeverMm;
                  })});
    }
  }
  const int steps = 24;
  for (int k = 1; k < steps; ++k) {
    const double at = range.low + range.width() * k / steps;
    const Scalar step = [=](const Reading& r, const Moment& m) {
      return t(r, m) >= at ? 1.0 : 0.0;
    };
    builder.add(builder.readings_in_all(), text("a shift at %.2f h", at),
                builder.in_all_readings(step));
    builder.add(builder.all_drives(), text("a shift at %.2f h", at), builder.along_all_rails(step));
  }
  for (int waves = 1; waves <= 4; ++waves) {
    const auto wave = [=](bool sine) -> Scalar {
      return [=](const Reading& r, const Moment& m) {
        const double turn = kPi * waves * (u(r, m) + 1);
        return sine ? std::sin(turn) : std::cos(turn);
      };
    };
    auto terms = builder.in_all_readings(wave(true));
    for (auto& term : builder.in_all_readings(wave(false))) terms.push_back(term);
    builder.add("readings", text("a wave of %.2f h", range.width() / waves), terms);
  }
}

void add_pose_shapes(Builder& builder) {
  const auto product = [](int a, int b) -> Scalar {
    return [=](const Reading&, const Moment& m) {
      return std::pow(m.pose.x_mm / kLeverMm, a) * std::pow(m.pose.y_mm / kLeverMm, b);
    };
  };
  const char* coordinates[] = {"x", "y", "phi"};
  for (int c = 0; c < 3; ++c) {
    if (!builder.is_measured(c)) continue;
    for (int degree = 1; degree <= 4; ++degree) {
      std::vector<DeviationOf> terms;
      for (int a = 0; a <= degree; ++a) terms.push_back(reading(c, product(a, degree - a)));
      builder.add(std::string("readings in ") + coordinates[c] + ", degree " +
                      std::to_string(degree) + " in the pose",
                  "all", terms);
    }
  }
  const bool in_plane = builder.rails() > 1;
  // x and y together, about the centre: fields that turn or stretch by more the farther out
  for (int degree = 1; degree <= 2; ++degree) {
    const auto farther = [=](const Moment& m) {
      return std::pow(std::hypot(m.pose.x_mm, m.pose.y_mm) / kLeverMm, degree) / kLeverMm;
    };
    if (in_plane) {
      builder.add(
          "readings, turned about the centre",
          "growing with the distance to the power of " + std::to_string(degree),
          {[=](const Reading&, const Moment& m) {
            return Deviation{.dX = {-m.pose.y_mm * farther(m), m.pose.x_mm * farther(m), 0}};
          }});
    }
    builder.add("readings, stretched about the centre",
                "growing with the distance to the power of " + std::to_string(degree),
                {[=](const Reading&, const Moment& m) {
                  return Deviation{.dX = {m.pose.x_mm * farther(m), m.pose.y_mm * farther(m), 0}};
                }});
  }
  const Regions regions = builder.regions();
  for (int ix = -1; ix <= 1; ++ix) {
    for (int iy = in_plane ? -1 : 0; iy <= (in_plane ? 1 : 0); ++iy) {
      const double cx = regions.x_mm + regions.step_mm * ix;
      const double cy = regions.y_mm + regions.step_mm * iy;
      const Scalar bump = [=](const Reading&, const Moment& m) {
        const double dx = (m.pose.x_mm - cx) / regions.width_mm;
        const double dy = (m.pose.y_mm - cy) / regions.width_mm;
        return std::exp(-dx * dx - dy * dy);
      };
      builder.add(in_plane ? text("region around x %.0f, y %.0f mm", cx, cy)
                           : text("region around x %.0f mm", cx),
                  "all", builder.in_all_readings(bump));
    }
  }
  const Scalar turned = [](const Reading&, const Moment& m) {
    return m.pose.phi_rad / rad_from_deg(4);
  };
  if (builder.range(turned).width() < 0.1) return;
  for (int degree = 1; degree <= 3; ++degree) {
    builder.add(
        builder.readings_in_all() + ", degree " + std::to_string(degree) + " in the orientation",
        "all", builder.in_all_readings([=](const Reading& r, const Moment& m) {
          return std::pow(turned(r, m), degree);
        }));
  }
  builder.add(builder.readings_in_all() + ", by the pose times the orientation", "all",
              {reading(0, [=](const Reading& r,
                              const Moment& m) { return turned(r, m) * m.pose.x_mm / kLeverMm; }),
               reading(0, [=](const Reading& r,
                              const Moment& m) { return turned(r, m) * m.pose.y_mm / kLeverMm; }),
               reading(1, [=](const Reading& r,
                              const Moment& m) { return turned(r, m) * m.pose.x_mm / kLeverMm; }),
               reading(1, [=](const Reading& r,
                              const Moment& m) { return turned(r, m) * m.pose.y_mm / kLeverMm; }),
               reading(2, [=](const Reading& r,
                              const Moment& m) { return turned(r, m) * m.pose.x_mm / kLeverMm; }),
               reading(2, [=](const Reading& r, const Moment& m) {
                 return turned(r, m) * m.pose.y_mm / kLeverMm;
               })});
}

void add_joint_shapes(Builder& builder) {
  for (int rail = 0; rail < builder.rails(); ++rail) {
    std::vector<DeviationOf> products;
    const int rails = builder.rails();
    for (int other = 0; other < builder.rails(); ++other) {
      products.push_back(along(rail, [=](const Reading&, const Moment& m) {
        return m.s_mm[other] * m.s_mm[(other + 1) % rails] / 1e4;
      }));
      if (other != rail) {
        products.push_back(along(rail, [=](const Reading&, const Moment& m) {
          return m.s_mm[other] * m.s_mm[other] / 1e4;
        }));
      }
    }
    if (rails > 1) {
      builder.add(builder.rail_name(rail) + ", by the travel of the other " + builder.drives() +
                      ", degree 2",
                  "all", products);
    }
    for (int harmonic = 1; builder.has_links() && harmonic <= 3; ++harmonic) {
      builder.add(
          builder.rail_name(rail) + ", by the angle of its " + builder.link() + ", harmonic " +
              std::to_string(harmonic),
          "all",
          {along(rail, [=](const Reading&,
                           const Moment& m) { return std::sin(harmonic * m.theta_rad[rail]); }),
           along(rail, [=](const Reading&, const Moment& m) {
             return std::cos(harmonic * m.theta_rad[rail]);
           })});
    }
  }
}

}  // namespace

std::vector<Shape> dictionary(const ResidualSpace& space) {
  Builder builder(space);
  add_rail_shapes(builder);
  add_periodic_shapes(builder);
  add_direction_shapes(builder);
  add_temperature_shapes(builder);
  add_time_shapes(builder);
  add_pose_shapes(builder);
  add_joint_shapes(builder);
  return builder.take();
}

std::vector<Shape> time_courses(const ResidualSpace& space) {
  Builder builder(space);
  add_time_shapes(builder);
  return builder.take();
}

}  // namespace trammel

#pragma once
// A laser tracker behind T2SA: SpatialAnalyzer drives the instrument, this asks it for points.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/device/freshness.hpp"
#include "app/device/nest_reading.hpp"
#include "app/device/t2sa_wire.hpp"

namespace trammel::device {

/// A nest and where T2SA keeps its point: "collection;group;point".
struct T2saTarget {
  std::string nest;
  std::string address;
};

struct T2saSettings {
  Endpoint server;
  double connect_timeout_s = 5;
  double reply_timeout_s = 60;  // a measurement is answered when it is done
  double warm_up_s = 600;       // a laser that is switched on may take so long
  NestSettings nests;
  std::vector<T2saTarget> points;       // of the platform, one a nest
  std::string object_group = {};        // instead of points: measured as a whole …
  std::string object_reference = {};    // … and its frame asked for, against this group if any
  std::vector<T2saTarget> base_points;  // measured before an epoch's first pose …
  std::vector<NestPoint> base;          // … where they are in B; none: nests.frame.T_B_T holds
  bool by_host_clock = true;  // its clock runs as this host's: not that of an emulated one
};

/// Connects at the first use and switches the laser on. A lost answer or connection is `timeout`,
/// and the next measurement begins on a new connection; a tracker that was never reached, or
/// answers nonsense, is a fault. An answer that names another point than was asked for, comes twice
/// or is not of now (freshness.hpp) is none: `timeout`. Every line that came is in raw_reply.
/// Proof: t2sa_test.cpp.
class T2saTracker : public Tracker {
 public:
  explicit T2saTracker(T2saSettings settings)
      : settings_(std::move(settings)), fresh_(settings_.by_host_clock) {}

  [[nodiscard]] std::string describe() const override;
  [[nodiscard]] Status beam() override;
  PoseReport measure(const Occasion& occasion) override;
  [[nodiscard]] bool sees_base() const override { return !settings_.base.empty(); }
  BaseReport measure_base(const Occasion& occasion) override;

 private:
  void connect();
  void warm_up();
  [[nodiscard]] PoseReport points_of(const std::vector<T2saTarget>& targets, bool moved,
                                     std::vector<NestPoint>& points);
  [[nodiscard]] PoseReport register_base(int epoch);
  [[nodiscard]] PoseReport measure_points(bool moved);
  [[nodiscard]] PoseReport measure_object(bool moved);
  [[nodiscard]] std::string not_of_now(const T2saTarget& target, const T2saPoint& point,
                                       double asked_s, bool moved);
  [[nodiscard]] PoseReport old(const std::string& why, const std::string& asked,
                               const T2saReply& reply);
  [[nodiscard]] Status lost(const LinkError& error);

  T2saSettings settings_;
  std::unique_ptr<T2saWire> wire_;
  Freshness fresh_;
  bool reached_ = false;
  std::vector<NestPoint> registered_ = {};    // the base nests as they were measured …
  std::optional<int> registered_epoch_ = {};  // … at the beginning of this epoch
};

}  // namespace trammel::device

#include "app/device/galil.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "app/device/galil_codes.hpp"
#include "app/device/galil_look.hpp"
#include "core/error.hpp"

namespace trammel::device {

namespace {

constexpr int kLinkTries = 3;    // to reach the controller again after a lost answer
constexpr int kAtCommanded = 1;  // stop code
constexpr const char* kNotFed =
    "; the controller has not heard from this program for too long and has stopped the rails "
    "itself, or its watch was ended: home again";

Status asked(const Watch& watch) { return watch ? watch() : Status::ok; }

}  // namespace

GalilStage::GalilStage(GalilSettings settings) : settings_(std::move(settings)) {
  validate(settings_);
}

GalilStage::~GalilStage() {
  if (identity_.empty()) return;  // never spoke with it
  try {
    if (!wire_) connect();
    static_cast<void>(halt({Status::ok, "", {}}, false));
    if (wire_) motors_off();
  } catch (const std::exception&) {  // nobody is left to tell; the drives' own limits remain
    wire_.reset();
  }
}

std::string GalilStage::name(std::size_t axis) const {
  return drive_name(settings_.machine, static_cast<int>(axis));
}

std::string GalilStage::place_text(const Displacements& l_mm) const {
  std::string text = "the " + drives_name(*settings_.machine.kind) + " stand at ";
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    text += fmt::format("{}{:.4f}", i == 0 ? "" : ", ", l_mm[static_cast<int>(i)]);
  }
  return text + " mm";
}

std::string GalilStage::describe() const {
  return "Galil DMC-41x3 at " + settings_.controller.text() +
         (identity_.empty() ? "" : ", " + identity_);
}

void GalilStage::connect() {
  wire_.reset();  // the controller has eight handles: give ours back first
  auto wire = std::make_unique<GalilWire>(settings_.controller, settings_.connect_timeout_s,
                                          settings_.reply_timeout_s);
  const std::string model = wire->command("\x12\x16");  // ^R^V
  if (!model.starts_with("DMC")) {
    throw LinkError(
        LinkError::Kind::nonsense,
        {.what = "this is no Galil controller", .got = model.substr(0, 60), .expected = "DMC…"});
  }
  identity_ = model + ", serial " + wire->command("MG _BN");
  wire_ = std::move(wire);
}

/// Runs `body` with a connection. However it fails, the rails are stopped before anybody is told.
StageReport GalilStage::guarded(const std::function<StageReport()>& body) {
  try {
    if (wire_ && !wire_->alive()) wire_.reset();  // closed while idle: nothing was in flight
    if (!wire_) {
      connect();
      if (homed_ && !remembers_set_up()) return halt({Status::ok, "reconnected", {}}, false);
    }
    StageReport report = body();
    if (report.ok()) return report;
    return halt(std::move(report), false);
  } catch (const LinkError& lost) {
    wire_.reset();
    if (identity_.empty()) return {Status::fault, lost.what()};  // it was never reached
    return halt({Status::timeout, lost.what()}, lost.kind != LinkError::Kind::no_connection);
  } catch (const GalilRefusal& refused) {
    return halt({of_refusal(refused.code), refused.what(), {}}, false);
  }
}

/// Stops the rails, waits until they rest, asks what is, and completes the report `why`. `lost`:
/// an answer was lost, so the outcome of what it should have answered is not known.
StageReport GalilStage::halt(StageReport why, bool lost) {
  std::string last;
  for (int tries = 1; tries <= kLinkTries; ++tries) {
    try {
      if (!wire_) connect();
      if (!bring_to_rest(*wire_, settings_)) {
        homed_ = false;
        return {Status::fault, why.detail + "; and the rails do not stop: use the emergency stop"};
      }
      const bool watched = is_watched();
      if (homed_ && !remembers_set_up()) {
        homed_ = false;
        if (watched && (may_retry(why.status) || why.ok())) {
          why = {Status::fault,
                 why.detail +
                     "; the controller has lost its set-up (a reset, power, or a servo "
                     "that is off): home again"};
        }
      }
      if (!watched) why = {Status::fault, why.detail + kNotFed};
      const bool counts_hold = homed_;
      why.encoder_mm = ask_displacements(*wire_, settings_.axes, "TP");
      why.commanded_mm = ask_displacements(*wire_, settings_.axes, "RP");
      if (why.status == Status::fault || why.status == Status::following_error) {
        homed_ = false;
        motors_off();
      }
      if (lost) why.detail += "; what it did is unknown, asked again it stands still";
      if (!why.ok() && counts_hold) why.detail += "; " + place_text(why.encoder_mm);
      return why;
    } catch (const LinkError& again) {
      wire_.reset();
      lost = true;
      last = again.what();
    } catch (const GalilRefusal& refused) {
      homed_ = false;
      return {Status::fault, why.detail + "; " + refused.what()};
    }
  }
  homed_ = false;
  return {Status::fault, why.detail + "; and nothing answers (" + last +
                             "): whether the stage moves is unknown, use the emergency stop"};
}

void GalilStage::motors_off() {
  for (const GalilAxis& axis : settings_.axes) wire_->command(std::string("MO") + axis.letter);
  if (watch_) GalilHostWatch::end(*wire_);
  watch_.reset();
}

/// True too where nobody has asked for it.
bool GalilStage::is_watched() { return !watch_ || GalilHostWatch::runs(*wire_); }

StageReport GalilStage::stop() {
  const std::unique_lock free(busy_, std::try_to_lock);
  if (!free) return stop_beside();
  if (identity_.empty()) return {Status::ok, "nothing was ever sent"};
  return halt({Status::ok, ""}, false);
}

/// Another call is at work, or hangs, in another thread: stops over a connection of its own. That
/// call then finds its axes stopped (SC 4) and ends.
StageReport GalilStage::stop_beside() const {
  try {
    GalilWire wire(settings_.controller, settings_.connect_timeout_s, settings_.reply_timeout_s,
                   "ST" + letters_of(settings_.axes));
    if (bring_to_rest(wire, settings_)) {
      return {Status::ok, "", ask_displacements(wire, settings_.axes, "TP"),
              ask_displacements(wire, settings_.axes, "RP")};
    }
    return {Status::fault, "the rails do not stop: use the emergency stop"};
  } catch (const DeviceError& error) {
    return {Status::fault, std::string(error.what()) +
                               ": whether the stage moves is unknown, use the emergency stop"};
  }
}

StageReport GalilStage::move(const Displacements& to_mm, const Watch& watch) {
  const std::scoped_lock lock(busy_);
  if (!homed_) return {Status::fault, "the stage is not homed"};
  return guarded([&] { return travel(to_mm, watch); });
}

/// All rails in proportion, from where they are commanded to be.
StageReport GalilStage::travel(const Displacements& to_mm, const Watch& watch) {
  std::vector<std::int64_t> to;
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const double l_mm = to_mm[static_cast<int>(i)];
    const Limits& limits = settings_.machine.drives[i].limits;
    const auto count = counts_of(settings_.axes[i], l_mm);
    if (!count || !(l_mm >= limits.l_min_mm && l_mm <= limits.l_max_mm)) {
      return {Status::limit, fmt::format("{} would leave its stroke ({} mm)", name(i), l_mm)};
    }
    to.push_back(*count);
  }
  const GalilMove plan = plan_galil_move(settings_.axes, ask_counts(*wire_, settings_.axes, "RP"),
                                         to, settings_.speed_mm_s, settings_.acceleration_mm_s2);
  std::string moving;
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    if (plan.axes[i].distance_counts != 0) moving += settings_.axes[i].letter;
  }
  if (const Status status = asked(watch); status != Status::ok) {
    return {status, std::string("not begun: ") + name_of(status)};
  }
  if (!moving.empty()) {
    if (!is_watched()) return {Status::fault, std::string("not begun") + kNotFed};
    start(plan);
    wire_->command("BG" + moving);
    StageReport report = follow(moving, plan.time_s + settings_.margin_s, kAtCommanded, watch);
    if (!report.ok()) return report;
  }
  StageReport report = settle(watch);
  if (!report.ok()) return report;
  if (ask_counts(*wire_, settings_.axes, "RP") != to)
    return {Status::fault, "the controller commands another place than sent"};
  return standing(to_mm);
}

/// Speed, acceleration and target of the axes that move. What the controller took is read back: a
/// value that it has cut to size would make the axes end apart.
void GalilStage::start(const GalilMove& move) {
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const GalilAxisMove& axis = move.axes[i];
    if (axis.distance_counts == 0) continue;
    set("AC", i, axis.acceleration);
    set("DC", i, axis.acceleration);
    set("SP", i, axis.speed);
    set("PA", i, axis.to_counts);
  }
}

void GalilStage::set(const char* name, std::size_t axis, std::int64_t value) {
  const std::string field = std::string(name) + settings_.axes[axis].letter;
  wire_->command(fmt::format("{}={}", field, value));
  const double took = wire_->ask_numbers(field + "=?").front();
  if (took == static_cast<double>(value)) return;
  throw GalilRefusal(0, {.what = "the controller took another value than was sent",
                         .where = {.field = field},
                         .got = fmt::format("{}", took),
                         .expected = fmt::format("{}", value)});
}

/// Until none of the axes `moving` moves. Each must end with the stop code `meant`; one that ends
/// otherwise ends the move of all.
StageReport GalilStage::follow(const std::string& moving, double time_s, int meant,
                               const Watch& watch) {
  const Deadline deadline = in_s(time_s);
  for (;;) {
    const GalilLook seen = look_at(*wire_, settings_.axes);
    for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
      const GalilLook::Axis& axis = seen.axes[i];
      if (moving.find(settings_.axes[i].letter) == std::string::npos) continue;
      if (!axis.moves && axis.stop_code != meant) {
        StageReport report = of_stop_code(axis.stop_code, name(i));
        if (report.ok()) report.status = Status::fault;  // 1 instead of 10: home was not found
        return report;
      }
      if (std::abs(axis.off_mm) > settings_.following_mm) {
        return {Status::following_error,
                fmt::format("{} is {:.4f} mm from its command while it moves, at most {} mm "
                            "are allowed",
                            name(i), axis.off_mm, settings_.following_mm)};
      }
    }
    if (!seen.any_moves()) return {Status::ok, ""};
    if (const Status status = asked(watch); status != Status::ok) {
      return {status, std::string("stopped while moving: ") + name_of(status)};
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      return {Status::timeout, fmt::format("the {} still move after {:.1f} s",
                                           drives_name(*settings_.machine.kind), time_s)};
    }
    wait_s(settings_.poll_s);
  }
}

/// Until all encoders have been within the band of their command for settle_s.
StageReport GalilStage::settle(const Watch& watch) {
  const Deadline deadline = in_s(settings_.settle_timeout_s);
  std::optional<Deadline> inside_until;
  for (;;) {
    const GalilLook seen = look_at(*wire_, settings_.axes);
    const auto now = std::chrono::steady_clock::now();
    std::size_t worst = 0;
    for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
      if (std::abs(seen.axes[i].off_mm) > std::abs(seen.axes[worst].off_mm)) worst = i;
    }
    if (seen.any_moves() || std::abs(seen.axes[worst].off_mm) > settings_.settle_band_mm) {
      inside_until.reset();
    } else if (!inside_until) {
      inside_until = in_s(settings_.settle_s);
    }
    if (inside_until && now >= *inside_until) return {Status::ok, ""};
    if (now >= deadline) {
      return {Status::timeout,
              fmt::format("{} does not settle: {:.4f} mm from its command, at most {} mm are "
                          "allowed",
                          name(worst), seen.axes[worst].off_mm, settings_.settle_band_mm)};
    }
    if (const Status status = asked(watch); status != Status::ok) {
      return {status, std::string("stopped while settling: ") + name_of(status)};
    }
    wait_s(settings_.poll_s);
  }
}

/// What the encoders say of themselves (TP) is where the rails stand, not only what the controller
/// says of the difference (TE).
StageReport GalilStage::standing(const Displacements& to_mm) {
  StageReport report{Status::ok, ""};
  report.encoder_mm = ask_displacements(*wire_, settings_.axes, "TP");
  report.commanded_mm = ask_displacements(*wire_, settings_.axes, "RP");
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const auto k = static_cast<int>(i);
    const double off_mm = report.encoder_mm[k] - to_mm[k];
    if (std::abs(off_mm) <= settings_.following_mm) continue;
    return {Status::following_error,
            fmt::format("the encoder of {} is {:.4f} mm from its command at rest, at most {} "
                        "mm are allowed",
                        name(i), off_mm, settings_.following_mm)};
  }
  return report;
}

}  // namespace trammel::device

#include "app/emulate/faults.hpp"

#include <algorithm>
#include <array>

#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel::emulate {

namespace {

struct KindRow {
  FaultKind kind;
  const char* name;
  bool stage, tracker;  // who can have it
};

constexpr std::array<KindRow, 9> kFaultKinds = {{
    {FaultKind::lost_reply, "lost-reply", true, true},
    {FaultKind::half_reply, "half-reply", true, true},
    {FaultKind::dropped, "dropped", true, true},
    {FaultKind::beam_break, "beam-break", false, true},
    {FaultKind::beam_lost, "beam-lost", false, true},
    {FaultKind::unstable, "unstable", false, true},
    {FaultKind::limit_hit, "limit-hit", true, false},
    {FaultKind::amplifier_fault, "amplifier-fault", true, false},
    {FaultKind::stall, "stall", true, false},
}};

bool can_have(const KindRow& row, Emulated device) {
  return device == Emulated::stage ? row.stage : row.tracker;
}

}  // namespace

const char* name_of(FaultKind kind) {
  const auto* row = std::find_if(kFaultKinds.begin(), kFaultKinds.end(),
                                 [kind](const KindRow& r) { return r.kind == kind; });
  return row == kFaultKinds.end() ? "?" : row->name;
}

std::string fault_kinds(Emulated device) {
  std::string all;
  for (const KindRow& row : kFaultKinds) {
    if (can_have(row, device)) all += (all.empty() ? "" : ", ") + std::string(row.name);
  }
  return all;
}

Fault parse_fault(std::string_view text, Emulated device) {
  const std::size_t at = text.find('@');
  const std::string_view name = text.substr(0, at);
  std::string_view count = at == std::string_view::npos ? "" : text.substr(at + 1);
  Fault fault;
  if (const std::size_t colon = count.find(':'); colon != std::string_view::npos) {
    fault.only = count.substr(colon + 1);
    count = count.substr(0, colon);
  }
  const auto* row = std::find_if(kFaultKinds.begin(), kFaultKinds.end(), [&](const KindRow& r) {
    return name == r.name && can_have(r, device);
  });
  const auto number = parse_integer(count);
  if (row == kFaultKinds.end() || !number || *number < 1) {
    throw UsageError({.what = "no such fault",
                      .where = {.field = "--fault"},
                      .got = std::string(text),
                      .expected = "KIND@N or KIND@N:TEXT, KIND one of " + fault_kinds(device) +
                                  ", N from 1: the N-th command (with TEXT in it), move or "
                                  "measurement"});
  }
  fault.kind = row->kind;
  fault.at = static_cast<std::uint64_t>(*number);
  return fault;
}

void Faults::add(const Fault& fault) {
  const std::lock_guard guard(mutex_);
  all_.push_back({fault});
}

bool Faults::strikes(FaultKind kind, std::string_view command) {
  const std::lock_guard guard(mutex_);
  bool now = false;
  for (Waiting& w : all_) {
    if (w.fault.kind != kind || w.done) continue;
    if (!w.fault.only.empty() && command.find(w.fault.only) == std::string_view::npos) continue;
    if (++w.seen == w.fault.at) now = w.done = true;
  }
  return now;
}

Answer over_bad_line(Faults& faults, std::string_view command, Answer answer) {
  // All three are asked, so that each counts every command.
  const bool lost = faults.strikes(FaultKind::lost_reply, command);
  const bool half = faults.strikes(FaultKind::half_reply, command);
  const bool dropped = faults.strikes(FaultKind::dropped, command);
  if (!lost && !half && !dropped) return answer;
  answer.close = dropped;
  answer.finish = [half = half && !lost && !dropped, bytes = std::move(answer.bytes),
                   finish = std::move(answer.finish)] {
    const std::string whole = finish ? finish() : bytes;
    return half ? whole.substr(0, whole.size() / 2) : std::string();
  };
  return answer;
}

int Faults::struck(FaultKind kind) const {
  const std::lock_guard guard(mutex_);
  return static_cast<int>(std::count_if(all_.begin(), all_.end(), [kind](const Waiting& w) {
    return w.fault.kind == kind && w.done;
  }));
}

}  // namespace trammel::emulate

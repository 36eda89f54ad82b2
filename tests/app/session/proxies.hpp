#pragma once
// What a proxy between the program and its tracker makes of an answer: it renames, holds back,
// freezes, dates, shifts.

#include <fmt/format.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <regex>
#include <string>
#include <utility>

#include "core/statistics/random.hpp"

namespace trammel::tests {

using Alter = std::function<void(std::string&)>;

/// "P2" of the answer of a measurement; empty for one that failed.
inline std::string point_of(const std::string& answer) {
  std::smatch found;
  const bool is = std::regex_search(answer, found, std::regex("Measurement (\\w+) result"));
  return is ? found[1].str() : "";
}

/// From the n-th answer for P1 on (1: the first), `change` what is said of the platform.
inline Alter from_pose(int n, Alter change) {
  return [n, change = std::move(change), poses = 0](std::string& answer) mutable {
    const std::string point = point_of(answer);
    poses += point == "P1" ? 1 : 0;
    if (point.starts_with('P') && poses >= n) change(answer);
  };
}

/// The point's answer comes under the name of another.
inline Alter renaming(char point = '1', char other = '2') {
  return [point, other](std::string& answer) {
    const std::size_t at = answer.find(std::string("P") + point + " result");
    if (at != std::string::npos) answer[at + 1] = other;
  };
}

/// `change` what is said of one point.
inline Alter only(std::string point, Alter change) {
  return [point = std::move(point), change = std::move(change)](std::string& answer) {
    if (point_of(answer) == point) change(answer);
  };
}

/// P2 is seen a second time, under the name of P3.
inline Alter one_nest_twice() {
  return [last = std::string()](std::string& answer) mutable {
    if (point_of(answer) == "P2") last = answer;
    if (point_of(answer) != "P3" || last.empty()) return;
    answer = last;
    renaming('2', '3')(answer);
  };
}

/// Each answer is the n-th before of the same point.
inline Alter lagging(std::size_t n = 1) {
  return [n, last = std::map<std::string, std::deque<std::string>>()](std::string& answer) mutable {
    std::deque<std::string>& before = last[point_of(answer)];
    before.push_back(answer);
    answer = before.front();
    if (before.size() > n) before.pop_front();
  };
}

/// Each answer is the one before, of whatever point.
inline Alter one_line_behind() {
  return [last = std::string()](std::string& answer) mutable {
    if (last.empty()) last = answer;
    std::swap(last, answer);
  };
}

/// The three nests take each other's places, under their right names: no side tells it.
inline Alter turned() {
  return [last = std::map<std::string, std::string>()](std::string& answer) mutable {
    static const std::map<std::string, std::string> kNext = {
        {"P1", "P2"}, {"P2", "P3"}, {"P3", "P1"}};
    const std::string point = point_of(answer);
    const auto next = kNext.find(point);
    if (next == kNext.end()) return;
    last[point] = answer;
    const auto there = last.find(next->second);
    if (there == last.end()) return;
    answer = there->second;
    answer.replace(answer.find(next->second), next->second.size(), point);
  };
}

/// Another text where the instrument said its x.
inline Alter saying(std::string x) {
  return [x = std::move(x)](std::string& answer) {
    answer = std::regex_replace(answer, std::regex("result -?[0-9.]+"), "result " + x);
  };
}

inline Alter frozen() {
  return [first = std::map<std::string, std::string>()](std::string& answer) mutable {
    answer = first.emplace(point_of(answer), answer).first->second;
  };
}

inline Alter dated(const char* date) {
  return [date](std::string& answer) {
    answer = std::regex_replace(answer, std::regex("\\d\\d/\\d\\d/\\d{4}"), date);
  };
}

/// All that the instrument sees stands elsewhere, along its x.
inline void shift(std::string& answer, double by_mm) {
  std::smatch found;
  if (!std::regex_search(answer, found, std::regex("result (-?[0-9.]+)"))) return;
  answer.replace(static_cast<std::size_t>(found.position(1)),
                 static_cast<std::size_t>(found.length(1)),
                 fmt::format("{:.6f}", std::stod(found[1].str()) + by_mm));
}

/// The answers before, and not to the last bit.
inline Alter lagging_unlike() {
  return [lag = lagging()](std::string& answer) {
    lag(answer);
    shift(answer, 1e-6);
  };
}

/// The tracker is knocked before its n-th pose: base nests, too, are seen elsewhere.
inline Alter knocked(int n, double by_mm) {
  return [n, by_mm, poses = 0](std::string& answer) mutable {
    poses += point_of(answer) == "P1" ? 1 : 0;
    if (poses >= n) shift(answer, by_mm);
  };
}

/// One answer in `of`, at random, is what `change` makes of it; the others are as they came.
inline Alter sometimes(Random random, std::uint64_t of, Alter change) {
  return [random, of, change = std::move(change)](std::string& answer) mutable {
    std::string changed = answer;
    change(changed);  // it may have a memory
    if (random.below(of) == 0) answer = changed;
  };
}

/// x in another unit.
inline Alter scaled(double by) {
  return [by](std::string& answer) {
    std::smatch found;
    if (!std::regex_search(answer, found, std::regex("result (-?[0-9.]+)"))) return;
    answer.replace(static_cast<std::size_t>(found.position(1)),
                   static_cast<std::size_t>(found.length(1)),
                   fmt::format("{:.6f}", by * std::stod(found[1].str())));
  };
}

/// From its n-th pose on it goes on moving, by as much with each pose.
inline Alter creeping(int n, double by_mm) {
  return [n, by_mm, poses = 0](std::string& answer) mutable {
    poses += point_of(answer) == "P1" ? 1 : 0;
    if (poses >= n) shift(answer, by_mm * (poses - n + 1));
  };
}

}  // namespace trammel::tests

#pragma once
// What a page is made of: sections that hold figures, tables, sentences and folds of these, as
// data.
//
// A figure has a kind that the page's script knows how to draw, and data; or it is absent and says
// why. A table has strings only: numbers are printed here, with the decimals they deserve.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mechanism/pose.hpp"

namespace trammel::report {

using Json = nlohmann::ordered_json;

struct FigureHead {
  std::string id;  // unique in the page: "surface-lsq-80-position"
  std::string title;
  std::string caption;  // what it is judged on, its unit, what is uncertain
};

Json figure(const FigureHead& head, const char* kind, Json data);
/// A figure that this campaign has no data for.
Json absent(const std::string& id, const std::string& title, const std::string& why);
Json table(const FigureHead& head, const std::vector<std::string>& columns, Json rows);
/// A list of sentences; without any it says `none`.
Json sentences(const std::string& id, const std::string& title, std::vector<std::string> lines,
               const std::string& none);
/// Items that are seen once it is opened; what is closed is not printed, but listed there.
Json fold(const std::string& id, const std::string& title, bool open, Json items);
Json section(const std::string& id, const std::string& title, Json items,
             const std::vector<std::string>& words = {});

/// A number for a picture: to 1e-5, a tenth of what trackers read, and of a smaller one three
/// digits, down to a tenth of a nanometre.
double drawn(double value);

/// The factor 1, 2 or 5 times a power of ten that makes `largest` about `wanted`, never more.
double magnification(double largest, double wanted);

}  // namespace trammel::report

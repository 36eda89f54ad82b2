// The command language as tables: registers, tells, operands, commands.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "app/emulate/galil.hpp"
#include "app/emulate/stage_link.hpp"
#include "app/files/numbers.hpp"
#include "store/provenance.hpp"

namespace trammel::emulate {

namespace {

constexpr double kMaxCounts = 2147483647.0;
constexpr double kSerialNumber = 15953;

// ---- words ----

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(at, from), text.size());
    parts.push_back(trimmed(text.substr(from, end - from)));
    from = end + 1;
  }
  return parts;
}

/// " 40960", "-3", " 500.0000": the place of the sign is always there.
std::string number(double value, int decimals) {
  return fmt::format("{: .{}f}", rounded(value, decimals), decimals);
}

std::string values(const std::vector<double>& all, int decimals, std::string_view between) {
  std::vector<std::string> words;
  for (const double value : all) words.push_back(number(value, decimals));
  return fmt::format("{}\r\n", fmt::join(words, between));
}

int axis_of(char letter) {
  if (letter < 'A' || letter >= 'A' + kAxes) throw Refused{4};
  return letter - 'A';
}

/// "ABC" -> 0, 1, 2; nothing or "*": all axes.
std::vector<int> axes_of(std::string_view letters) {
  std::vector<int> axes;
  if (letters.empty() || letters == "*") {
    for (int k = 0; k < kAxes; ++k) axes.push_back(k);
  }
  if (letters != "*") {
    for (const char letter : letters) axes.push_back(axis_of(letter));
  }
  return axes;
}

// ---- registers: XXA=n, XX n,n, XXA=?, XX ? ----

struct Register {
  std::string_view name;
  double (*get)(Galil&, int axis);
  void (*set)(Galil&, int axis, double value);
  double low, high;
  double multiple;  // a value is cut down to a whole multiple
  int decimals;
  bool while_running;
};

template <double Axis::*kField>
double get_field(Galil& galil, int axis) {
  return galil.axis(axis).*kField;
}
template <double Axis::*kField>
void set_field(Galil& galil, int axis, double value) {
  galil.axis(axis).*kField = value;
}
/// The same, and the next BG does this.
template <double Axis::*kField, Next kNext>
void set_next(Galil& galil, int axis, double value) {
  galil.axis(axis).*kField = value;
  galil.axis(axis).next = kNext;
}

template <double Axis::*kField>
constexpr Register plain(std::string_view name, double low, double high, double multiple,
                         int decimals = 0) {
  return {name, &get_field<kField>, &set_field<kField>, low, high, multiple, decimals, true};
}

double told_position(Galil& galil, int axis) { return tells(galil, axis).position; }
void set_position(Galil& galil, int axis, double counts) { galil.define_position(axis, counts); }

// Ranges and steps of SP, AC, DC: [S]; the others: [K].
const std::array<Register, 16>& registers() {
  static const std::array<Register, 16> all = {{
      {"PA", &get_field<&Axis::target>, &set_next<&Axis::target, Next::position>, -kMaxCounts - 1,
       kMaxCounts, 1, 0, false},
      {"PR", &get_field<&Axis::relative>, &set_next<&Axis::relative, Next::relative>,
       -kMaxCounts - 1, kMaxCounts, 1, 0, false},
      {"JG", &get_field<&Axis::jog_speed>, &set_next<&Axis::jog_speed, Next::jog>, -15e6, 15e6, 2,
       0, false},
      {"DP", &told_position, &set_position, -kMaxCounts - 1, kMaxCounts, 1, 0, false},
      plain<&Axis::speed>("SP", 2, 15e6, 2),
      plain<&Axis::accel>("AC", 1024, 1073740800, 1024),
      plain<&Axis::decel>("DC", 1024, 1073740800, 1024),
      plain<&Axis::home_speed>("HV", 2, 15e6, 2),
      plain<&Axis::forward_soft>("FL", -kMaxCounts - 1, kMaxCounts, 1),
      plain<&Axis::reverse_soft>("BL", -kMaxCounts - 1, kMaxCounts, 1),
      plain<&Axis::error_limit>("ER", 0, kMaxCounts, 1),
      plain<&Axis::off_on_error>("OE", 0, 3, 1),
      plain<&Axis::limits_disabled>("LD", 0, 3, 1),
      plain<&Axis::kp>("KP", 0, 1023.875, 0.125, 4),
      plain<&Axis::ki>("KI", 0, 255.999, 0.0009765625, 4),
      plain<&Axis::kd>("KD", 0, 4095.875, 0.125, 4),
  }};
  return all;
}

struct Assignment {
  int axis = 0;
  std::string_view value;  // "?" asks
};

std::vector<Assignment> assignments(std::string_view arguments) {
  std::vector<Assignment> all;
  if (const std::size_t equals = arguments.find('='); equals != std::string_view::npos) {
    const std::string_view letters = trimmed(arguments.substr(0, equals));
    if (letters.empty()) throw Refused{4};
    for (const int axis : axes_of(letters)) {
      all.push_back({axis, trimmed(arguments.substr(equals + 1))});
    }
    return all;
  }
  const std::vector<std::string_view> fields = split(arguments, ',');
  if (fields.size() > kAxes) throw Refused{4};
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (!fields[k].empty()) all.push_back({static_cast<int>(k), fields[k]});
  }
  if (all.empty()) throw Refused{50};
  return all;
}

std::string use_register(Galil& galil, const Register& reg, std::string_view arguments) {
  std::vector<double> asked;
  const std::vector<Assignment> all = assignments(arguments);
  for (const Assignment& a : all) {
    if (a.value == "?") {
      asked.push_back(reg.get(galil, a.axis));
      continue;
    }
    const double value = std::trunc(galil.value(a.value) / reg.multiple) * reg.multiple;
    if (!(value >= reg.low && value <= reg.high)) throw Refused{6};
    if (!reg.while_running && galil.axis(a.axis).running) throw Refused{7};
    reg.set(galil, a.axis, value);
  }
  return asked.empty() ? "" : values(asked, reg.decimals, ",");
}

// ---- tells: TPA, TP, MG _TPA ----

struct Tell {
  std::string_view name;
  double (*get)(Galil&, int axis);
  int decimals;
};

constexpr std::array<Tell, 8> kTells = {{
    {"TP", &told_position, 0},
    {"RP", [](Galil& g, int axis) { return tells(g, axis).commanded; }, 0},
    {"TD", [](Galil&, int) { return 0.0; }, 0},  // no second encoder is wired
    {"TE", [](Galil& g, int axis) { return tells(g, axis).error; }, 0},
    {"TV", [](Galil& g, int axis) { return tells(g, axis).velocity; }, 0},
    {"TT", [](Galil& g, int axis) { return tells(g, axis).torque_v; }, 4},
    {"SC", [](Galil& g, int axis) -> double { return g.axis(axis).stop_code; }, 0},
    {"TS", [](Galil& g, int axis) -> double { return tells(g, axis).status; }, 0},
}};

std::string use_tell(Galil& galil, const Tell& tell, std::string_view arguments) {
  std::vector<double> all;
  for (const int axis : axes_of(arguments)) all.push_back(tell.get(galil, axis));
  return values(all, tell.decimals, ",");
}

// ---- operands that are neither ----

bool bit(Galil& galil, int axis, int which) {
  return (tells(galil, axis).status >> which & 1) != 0;
}

constexpr std::array<Tell, 7> kOperands = {{
    {"BG", [](Galil& g, int axis) { return g.axis(axis).running ? 1.0 : 0.0; }, 4},
    {"MO", [](Galil& g, int axis) { return g.axis(axis).off ? 1.0 : 0.0; }, 4},
    {"LF", [](Galil& g, int axis) { return bit(g, axis, 3) ? 1.0 : 0.0; }, 4},
    {"LR", [](Galil& g, int axis) { return bit(g, axis, 2) ? 1.0 : 0.0; }, 4},
    {"HM", [](Galil& g, int axis) { return bit(g, axis, 1) ? 1.0 : 0.0; }, 4},
    {"BN", [](Galil&, int) { return kSerialNumber; }, 4},
    {"TC", [](Galil& g, int) -> double { return g.error; }, 4},
}};

template <class Row, std::size_t kRows>
const Row* named(const std::array<Row, kRows>& rows, std::string_view name) {
  const auto row =
      std::find_if(rows.begin(), rows.end(), [name](const Row& r) { return r.name == name; });
  return row == rows.end() ? nullptr : &*row;
}

// ---- variables and arrays ----

bool is_name(std::string_view text) {
  if (text.empty() || text.size() > 8) return false;
  if (std::isalpha(static_cast<unsigned char>(text[0])) == 0) return false;
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; });
}

struct Element {
  std::string_view array, index;
};
std::optional<Element> element(std::string_view text) {
  const std::size_t open = text.find('[');
  if (open == std::string_view::npos || !text.ends_with(']')) return {};
  return Element{text.substr(0, open), text.substr(open + 1, text.size() - open - 2)};
}

double& element_of(Galil& galil, const Element& e) {
  const auto array = galil.arrays.find(e.array);
  if (array == galil.arrays.end()) throw Refused{82};
  const double index = galil.value(e.index);
  if (!(index >= 0 && index < static_cast<double>(array->second.size()))) throw Refused{6};
  return array->second[static_cast<std::size_t>(index)];
}

std::string assign(Galil& galil, std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) throw Refused{1};
  const std::string_view name = trimmed(text.substr(0, equals));
  const std::string_view value = trimmed(text.substr(equals + 1));
  if (const auto e = element(name)) {
    element_of(galil, *e) = galil.value(value);
    return "";
  }
  if (!is_name(name)) throw Refused{1};
  const double number = galil.value(value);
  constexpr std::size_t kMaxVariables = 254;
  if (galil.variables.size() >= kMaxVariables && !galil.variables.contains(name)) throw Refused{9};
  galil.variables.insert_or_assign(std::string(name), number);
  return "";
}

// ---- commands ----

/// A whole number from 0 to `high`; `absent` for nothing.
int small_number(std::string_view text, int high, int absent) {
  if (text.empty()) return absent;
  const auto n = parse_integer(text);
  if (!n) throw Refused{4};
  if (*n < 0 || *n > high) throw Refused{6};
  return *n;
}

template <bool kOn>
std::string switch_motors(Galil& galil, std::string_view arguments) {
  for (const int axis : axes_of(arguments)) galil.motor(axis, kOn);
  return "";
}

template <Next kNext>
std::string find_home(Galil& galil, std::string_view arguments) {
  for (const int axis : axes_of(arguments)) {
    if (galil.axis(axis).running) throw Refused{7};
    galil.axis(axis).next = kNext;
  }
  return "";
}

std::string begin(Galil& galil, std::string_view arguments) {
  galil.begin(axes_of(arguments));
  return "";
}

std::string stop(Galil& galil, std::string_view arguments) {
  for (const int axis : axes_of(arguments)) galil.stop(axis);
  return "";
}

std::string halt_program(Galil& galil, std::string_view arguments) {
  const int only = small_number(arguments, Programs::kThreads - 1, -1);
  for (int k = 0; k < Programs::kThreads; ++k) {
    if (only < 0 || k == only) galil.programs.halt(k);
  }
  return "";
}

std::string abort_motion(Galil& galil, std::string_view arguments) {
  const bool spares_programs = small_number(arguments, 1, 0) == 1;
  if (!spares_programs) halt_program(galil, "");
  galil.abort();
  return "";
}

std::string message(Galil& galil, std::string_view arguments) {
  std::vector<double> all;
  for (const std::string_view word : split(arguments, ',')) all.push_back(galil.value(word));
  return values(all, 4, "");  // the place of the sign parts them
}

std::string tell_code(Galil& galil, std::string_view arguments) {
  const bool words = small_number(arguments, 1, 0) == 1;
  const int code = std::exchange(galil.error, 0);  // [K] reading clears it
  return words && code != 0 ? fmt::format(" {}\r\n", error_text(code))
                            : fmt::format(" {}\r\n", code);
}

std::string set_echo(Galil& galil, std::string_view arguments) {
  galil.echo = small_number(arguments, 1, 1) == 1;
  return "";
}

std::string mark_unsolicited(Galil& galil, std::string_view arguments) {
  if (arguments == "?") return values({static_cast<double>(galil.unsolicited)}, 0, ",");
  const int mode = small_number(arguments, 2, 2);
  if (mode == 0) throw Refused{6};
  galil.unsolicited = mode;  // what programs print is not sent
  return "";
}

/// "#HOST,1": the thread is 0 where none stands.
std::string execute(Galil& galil, std::string_view arguments) {
  const auto words = split(arguments, ',');
  const int thread = words.size() < 2 ? 0 : small_number(words[1], Programs::kThreads - 1, 0);
  galil.programs.start(words[0], thread);
  return "";
}

std::string in_programs_alone(Galil&, std::string_view) { throw Refused{2}; }

std::string close_handles(Galil&, std::string_view arguments) {
  if (arguments != "T=>-1") throw Refused{4};  // all UDP handles; there is none
  return "";
}

std::string dimension(Galil& galil, std::string_view arguments) {
  const auto e = element(arguments);
  constexpr double kMaxElements = 24000;
  if (!e || !is_name(e->array)) throw Refused{4};
  const double size = galil.value(e->index);
  if (!(size >= 1 && size <= kMaxElements)) throw Refused{6};
  double used = size;
  for (const auto& [name, array] : galil.arrays) used += static_cast<double>(array.size());
  if (used > kMaxElements) throw Refused{66};
  galil.arrays[std::string(e->array)].resize(static_cast<std::size_t>(size));
  return "";
}

std::string identify(Galil&, std::string_view) {
  return "FW, DMC4183 Rev 1.3h\r\nDMC, 4103, Rev 11\r\nAMP1, 44140, Rev 3\r\n"
         "AMP2, 44140, Rev 3\r\nEMULATED, trammel " +
         store::this_program().tool_version + "\r\n";
}

struct Command {
  std::string_view name;
  std::string (*run)(Galil&, std::string_view arguments);
};

constexpr std::array<Command, 25> kCommands = {{
    {"BG", &begin},
    {"ST", &stop},
    {"AB", &abort_motion},
    {"SH", &switch_motors<true>},
    {"MO", &switch_motors<false>},
    {"HM", &find_home<Next::home>},
    {"FI", &find_home<Next::index>},
    {"MG", &message},
    {"TC", &tell_code},
    {"EO", &set_echo},
    {"CW", &mark_unsolicited},
    {"IH", &close_handles},
    {"DM", &dimension},
    {"ID", &identify},
    {"TH", [](Galil& g, std::string_view) { return g.handles_text(); }},
    {"XQ", &execute},
    {"HX", &halt_program},
    {"WT", &in_programs_alone},
    {"JP", &in_programs_alone},
    {"AM", &in_programs_alone},
    {"EN", &in_programs_alone},
    {"QR", [](Galil& g, std::string_view) { return data_record(g); }},
    {"QZ",
     [](Galil&, std::string_view) {
       return values({kAxes, 52, 26, 36}, 0, ",");
     }},
    {"\x12\x16", [](Galil&, std::string_view) { return std::string("DMC4183 Rev 1.3h\r\n"); }},
    // Not Galil's: where the rails of the emulated robot truly are, for an emulated tracker.
    {kAskStanding, [](Galil& g, std::string_view) { return g.standing_text() + "\r\n"; }},
}};

}  // namespace

double operand(Galil& galil, std::string_view name) {
  const std::string_view what = name.substr(0, 2);
  if (name.size() < 2 || name.size() > 3) throw Refused{4};
  if (what == "XQ") return galil.programs.place(small_number(name.substr(2), 7, 0));
  const int axis = name.size() == 3 ? axis_of(name[2]) : 0;
  if (const Tell* tell = named(kOperands, what)) return tell->get(galil, axis);
  if (const Tell* tell = named(kTells, what)) return tell->get(galil, axis);
  if (const Register* reg = named(registers(), what)) return reg->get(galil, axis);
  throw Refused{4};
}

double Galil::value(std::string_view text) {
  text = trimmed(text);
  if (text == "?") throw Refused{51};
  if (const auto number = parse_number(text)) return *number;
  if (text.starts_with('-')) return -value(text.substr(1));
  if (text.starts_with('_')) return operand(*this, text.substr(1));
  if (const auto e = element(text)) return element_of(*this, *e);
  const auto variable = variables.find(text);
  if (variable != variables.end()) return variable->second;
  throw Refused{is_name(text) ? 9 : 4};
}

std::string run_command(Galil& galil, std::string_view text) {
  if (text == kAskStanding) return named(kCommands, text)->run(galil, "");
  const std::string_view name = text.substr(0, 2);
  const std::string_view arguments = trimmed(text.substr(name.size()));
  if (const Register* reg = named(registers(), name)) return use_register(galil, *reg, arguments);
  if (const Tell* tell = named(kTells, name)) return use_tell(galil, *tell, arguments);
  if (const Command* command = named(kCommands, name)) return command->run(galil, arguments);
  return assign(galil, text);
}

}  // namespace trammel::emulate

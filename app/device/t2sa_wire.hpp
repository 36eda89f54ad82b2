#pragma once
// Lines to and from T2SA, the TCP face of SpatialAnalyzer. README.md has the grammar and its
// source.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "app/device/device.hpp"
#include "app/device/tcp.hpp"

namespace trammel::device {

struct T2saReply {
  bool accepted = false;  // ACK; else ERR
  int code = 0;
  std::string body = {};
  std::string raw = {};  // the line as it came
};

/// "ACK-300 text", "ERR-201 text". Nothing for a line of another form.
std::optional<T2saReply> parse_t2sa_reply(const std::string& line);

struct T2saPoint {
  Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();
  bool good = false;                         // the word after the time [K: the point was accepted]
  std::string name = {};                     // PT: of the point that was asked for [K]
  std::optional<std::int64_t> stamp_s = {};  // parse_stamp_s
};
/// "Single Point Measurement PT result x,y,z MM/DD/YYYY HH:MM:SS True".
std::optional<T2saPoint> parse_t2sa_point(const std::string& body);

/// Where a frame stands, mm and degrees about fixed axes, R = Rz Ry Rx [K].
struct T2saFrame {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  std::string name = {};  // with that of the group in it [K]
  std::optional<std::int64_t> stamp_s = {};
};
/// "Object Offset Report NAME;X:..;Y:..;Z:..;Rx:..;Ry:..;Rz:..;date time".
std::optional<T2saFrame> parse_t2sa_offset(const std::string& body);

/// Whether a T2SA name is, or holds, another; capitals or not.
bool t2sa_name_is(std::string_view name, std::string_view expected);
bool t2sa_name_holds(std::string_view name, std::string_view part);

/// The rotation Rz(c) Ry(b) Rx(a), angles in rad, and a shift.
Eigen::Isometry3d fixed_axes(const Eigen::Vector3d& shift_mm, const Eigen::Vector3d& angles_rad);

/// What an ERR code means for the runner. A code that is not in the table is a fault.
Status status_of_t2sa(int code);
inline constexpr int kT2saBusy = 201;

class T2saWire {
 public:
  /// Throws LinkError.
  T2saWire(const Endpoint& to, double connect_timeout_s, double reply_timeout_s);

  /// One line out, one line back. While the answer is "busy" a `patient` caller asks again. Throws
  /// LinkError:
  /// nothing in time, half a line, a line of another form, one that nobody asked for.
  T2saReply ask(const std::string& line, bool patient = true);
  /// The answer to `line` was that to another question: closes the line, throws LinkError.
  [[noreturn]] void out_of_step(const std::string& line, const std::string& got,
                                const std::string& expected);

 private:
  std::string receive_line(const std::string& asked, Deadline deadline);

  TcpLink link_;
  double reply_timeout_s_;
  std::string buffer_;
};

}  // namespace trammel::device

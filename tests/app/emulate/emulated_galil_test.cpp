// The controller's language and its axes, without a socket and with a clock of the test's own.

#include "app/emulate/galil.hpp"

#include <cstring>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

using tests::Controller;

namespace {

void servo_on(Controller& c) { REQUIRE(c("SHABC") == ":"); }

/// Begins, and waits until everything rests.
void go(Controller& c, const std::string& line) {
  REQUIRE(c(line).find('?') == std::string::npos);
  c.now_s += 1000;
}

}  // namespace

TEST_CASE("every form of a register sets and asks the same", "[emulate]") {
  Controller c;
  CHECK(c("SPA=10666") == ":");
  CHECK(c("SPA=?") == " 10666\r\n:");
  CHECK(c("MG _SPA") == " 10666.0000\r\n:");
  CHECK(c("SP 2000,,4000") == ":");
  CHECK(c("SP ?,?,?") == " 2000, 25000, 4000\r\n:");
  CHECK(c("AC*=102400") == ":");
  CHECK(c("ACH=?") == " 102400\r\n:");
  CHECK(c("a=5;PAB=a;PAB=?;PRC=-a;PRC=?") ==
        ":: 5\r\n:"
        ":-5\r\n:");
  CHECK(c("KPA=6.125;KPA=?") == ": 6.1250\r\n:");
  CHECK(c("FLA=?;BLA=?") == " 2147483647\r\n:-2147483648\r\n:");
}

TEST_CASE("speeds are cut to 2 counts/s and accelerations to 1024 counts/s^2", "[emulate]") {
  Controller c;
  c("SPA=10667;ACA=150000;DCA=1073740800");
  CHECK(c("SPA=?;ACA=?;DCA=?") == " 10666\r\n: 149504\r\n: 1073740800\r\n:");
}

TEST_CASE("each refusal leaves its code", "[emulate]") {
  Controller c;
  servo_on(c);
  struct Row {
    const char* line;
    int code;
  };
  for (const Row& row : std::vector<Row>{{"bg", 1},
                                         {"XY", 1},
                                         {"SPA=abc[", 4},
                                         {"PAJ=1", 4},
                                         {"MG _ZZA", 4},
                                         {"IHQ", 4},
                                         {"SPA=20000000", 6},
                                         {"ACA=1073741824", 6},
                                         {"PAA=3000000000", 6},
                                         {"ERA=-1", 6},
                                         {"SPA=nobody", 9},
                                         {"BGD", 20},
                                         {"SP", 50},
                                         {"PA ,,", 50},
                                         {"MG ?", 51},
                                         {"DM big[30000]", 6},
                                         {"none[0]=1", 82}}) {
    CAPTURE(row.line);
    CHECK(c.code_after(row.line) == row.code);
    CHECK(c(std::string(row.line)) == "?");
  }
  CHECK(c("DM a1[20000]") == ":");
  CHECK(c.code_after("DM a2[20000]") == 66);
  REQUIRE(c("PAA=40960;BGA") == "::");
  for (const char* line : {"PAA=1", "PRA=1", "DPA=0", "SHA", "MOA", "HMA"}) {
    CAPTURE(line);
    CHECK(c.code_after(line) == 7);
  }
  CHECK(c.code_after("BGA") == 21);
  CHECK(c.code_after("FLB=100000;BLB=-100000;SPA=2000") == 0);  // these may change while it runs
  c.now_s += 100;
  CHECK(c.code_after("DPB=200000;PAB=300000;BGB") == 22);
  CHECK(c("PAB=0;BGB") == "::");  // back is allowed
  c.galil.line_too_long();
  CHECK(c("TC1") == " 5 Input buffer full\r\n:");
}

TEST_CASE("TC tells the last error, with words on demand, and forgets it", "[emulate]") {
  Controller c;
  c("BGA");
  CHECK(c("MG _TC") == " 20.0000\r\n:");
  CHECK(c("TC1") == " 20 Begin not valid with motor off\r\n:");
  CHECK(c("TC1") == " 0\r\n:");
  c("SP");
  CHECK(c("TC") == " 50\r\n:");
  c("bg");
  CHECK(c("TC 0") == " 1\r\n:");
}

TEST_CASE("one sub-command of a line may be refused, the others are carried out", "[emulate]") {
  Controller c;
  CHECK(c("SPA=2000;bg;SPB=3000") == ":?:");
  CHECK(c("SP ?,?") == " 2000, 3000\r\n:");
  CHECK(c("") == ":");
}

TEST_CASE("a move takes its time and arrives at its count", "[emulate]") {
  Controller c;
  servo_on(c);
  c("SPA=16384;ACA=256000;DCA=256000;PAA=40960;BGA");
  CHECK(c("SCA") == " 0\r\n:");
  CHECK(c("MG _BGA") == " 1.0000\r\n:");
  const double duration_s = 40960.0 / 16384 + 16384.0 / 256000;  // of the trapezoid
  c.now_s = 0.5 * duration_s;
  CHECK_THAT(c.number("RPA"), WithinAbs(20480, 1));
  CHECK_THAT(c.number("TEA"), WithinAbs(16384 * Motion::kServoLag_s, 1));
  CHECK(c.number("TPA") == c.number("RPA") - c.number("TEA"));
  CHECK_THAT(c.number("TVA"), WithinAbs(16384, 2));
  c.now_s = duration_s - 1e-6;
  CHECK(c("MG _BGA;SCA") == " 1.0000\r\n: 0\r\n:");
  c.now_s = duration_s + 1e-6;
  CHECK(c("MG _BGA;SCA") == " 0.0000\r\n: 1\r\n:");
  CHECK(c.number("TEA") > 10);  // the command has arrived, the motor still settles
  c.now_s += 0.1;
  CHECK(c("TPA;TEA;TVA") == " 40960\r\n: 0\r\n: 0\r\n:");
}

TEST_CASE("three axes begin together, and an axis with nothing wired does not follow",
          "[emulate]") {
  Controller c;
  c("SH");
  go(c, "PRA=100;PRB=200;PRC=-300;PRD=400;BGABCD");
  CHECK(c("TP") == " 100, 200,-300, 0, 0, 0, 0, 0\r\n:");
  CHECK(c("RP") == " 100, 200,-300, 400, 0, 0, 0, 0\r\n:");
  CHECK(c("TED") == " 400\r\n:");
}

TEST_CASE("of axes begun together none moves when one of them may not", "[emulate]") {
  Controller c;
  c("SHAB;PAA=100;PAB=100;PAC=100");
  CHECK(c.code_after("BGABC") == 20);
  c.now_s += 10;
  CHECK(c("TPA;TPB") == " 0\r\n: 0\r\n:");
}

TEST_CASE("ST slows down and says 4, AB stands at once and says 7", "[emulate]") {
  Controller c;
  servo_on(c);
  c("PAA=80000;PAB=80000;BGAB");
  c.now_s = 1;
  c("STA");
  CHECK(c("SCA;MG _BGA") == " 0\r\n: 1.0000\r\n:");
  c.now_s = 1.2;
  CHECK(c("SCA;SCB") == " 4\r\n: 0\r\n:");
  const double at = c.number("RPB");
  c("AB1");
  CHECK_THAT(c.number("RPB"), WithinAbs(at, 1));
  CHECK(c("SCB;MG _BGB") == " 7\r\n: 0.0000\r\n:");
  c.now_s = 5;
  CHECK_THAT(c.number("TPB"), WithinAbs(at, 1));
  CHECK(c.number("TPA") < 30000);
}

TEST_CASE("a soft limit decelerates, says so, and lets back", "[emulate]") {
  Controller c;
  servo_on(c);
  c("FLA=20000;PAA=20000");
  go(c, "BGA");
  CHECK(c("SCA") == " 1\r\n:");  // up to the limit is allowed
  go(c, "PAA=0;BGA");
  go(c, "PAA=60000;BGA");
  CHECK(c("SCA") == " 2\r\n:");
  const double overrun = 25000.0 * 25000 / (2 * 256000);
  CHECK_THAT(c.number("TPA"), WithinAbs(20000 + overrun, 2));
  CHECK(c.code_after("BGA") == 22);
  go(c, "PAA=-60000;BLA=-100;BGA");
  CHECK(c("SCA") == " 3\r\n:");
}

TEST_CASE("a limit switch lies just outside the stroke and is seen", "[emulate]") {
  Controller c;
  servo_on(c);
  const double home_mm = inverse(paper_mechanism().geometry, Pose{}).l_mm[0];
  const double counts_per_mm = 819.2;
  CHECK(c("MG _LFA,_LRA") == " 1.0000 1.0000\r\n:");
  go(c, "SPA=100000;PAA=2000000;BGA");
  CHECK(c("SCA") == " 2\r\n:");
  CHECK(c("MG _LFA,_LRA") == " 0.0000 1.0000\r\n:");
  CHECK(c.number("TPA") > (602 - home_mm) * counts_per_mm - 1);
  CHECK(c.number("TPA") < (630 - home_mm) * counts_per_mm);
  CHECK((static_cast<int>(c.number("TSA")) & 0x0c) == 0x04);
  go(c, "PRA=-2000000;BGA");
  CHECK(c("SCA") == " 3\r\n:");
  CHECK(c("MG _LFA,_LRA") == " 1.0000 0.0000\r\n:");
  CHECK(c.number("TPA") < (-2 - home_mm) * counts_per_mm + 1);
  go(c, "LDA=3;PRA=-1000;BGA");  // disabled, the switch is still seen and does nothing
  CHECK(c("SCA;MG _LRA") == " 1\r\n: 0.0000\r\n:");
}

TEST_CASE("a jog goes on until it is stopped or meets a limit", "[emulate]") {
  Controller c;
  servo_on(c);
  c("JGA=-40000;BGA");
  c.now_s = 3;
  CHECK(c("MG _BGA") == " 1.0000\r\n:");
  CHECK(c.number("TPA") < -100000);
  c.now_s = 1000;
  CHECK(c("SCA") == " 3\r\n:");
}

TEST_CASE("homing ends on the switch wherever the register said it was", "[emulate]") {
  EmulatedRobot::Rails rails;
  rails[0].start_mm = 12.5;
  rails[1].sign = -1;
  rails[1].start_mm = -3;
  Controller c(rails);
  servo_on(c);
  CHECK(c("TPA") == " 0\r\n:");  // at power-up
  go(c, "HMABC;BGABC");
  CHECK(c("SC") == " 10, 10, 10, 1, 1, 1, 1, 1\r\n:");
  CHECK(c("TPA;TPB;RPC") == " 0\r\n: 0\r\n: 0\r\n:");
  const Displacements home = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  CHECK((c.robot.standing().l_mm - home).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(c.robot.standing().from_mm == c.robot.standing().l_mm);  // no lash on either side
  go(c, "PAB=819200;BGB");
  CHECK(c("SCB") == " 2\r\n:");  // forward in counts is the low end of this rail
}

TEST_CASE("rails stand where lead, gear, sign and lead error put them", "[emulate]") {
  EmulatedRobot::Rails rails;
  rails[0] = {.lead_mm = 5, .counts_per_rev = 4000, .gear = 2, .sign = -1, .home_mm = 250};
  rails[1].lead_error = 1e-3;
  Controller c(rails);
  servo_on(c);
  const double before = c.robot.standing().l_mm[1];
  go(c, "PAA=16000;PAB=8192;BGAB");
  CHECK_THAT(c.robot.standing().l_mm[0], WithinAbs(240, 1e-9));
  CHECK_THAT(c.robot.standing().from_mm[0], WithinAbs(250, 1e-9));
  CHECK_THAT(c.robot.standing().l_mm[1] - before, WithinAbs(10.01, 1e-9));
  rails[2].lead_mm = -1;
  CHECK_THROWS_AS(Controller(rails), InputError);
}

TEST_CASE("a define of position moves nothing", "[emulate]") {
  Controller c;
  servo_on(c);
  const Standing before = c.robot.standing();
  CHECK(c("DPA=1000;TPA;RPA;TEA") == ": 1000\r\n: 1000\r\n: 0\r\n:");
  CHECK(c.robot.standing() == before);
  go(c, "PAA=1000;BGA");
  CHECK(c.robot.standing().l_mm == before.l_mm);
}

TEST_CASE("waiting takes no time of work, moving takes its own and the settling", "[emulate]") {
  Controller c;
  servo_on(c);
  go(c, "SPA=16384;ACA=256000;DCA=256000;PAA=40960;BGA");
  const double once = c.robot.standing().time_s;
  CHECK_THAT(once, WithinAbs(40960.0 / 16384 + 16384.0 / 256000 + 5, 1e-9));
  c.now_s += 1e5;
  CHECK(c.robot.standing().time_s == once);
}

TEST_CASE("identification and handles say what they are", "[emulate]") {
  Controller c;
  const std::string model = c("\x12\x16");
  CHECK(model == "DMC4183 Rev 1.3h\r\n:");
  CHECK(model[5] == '8');
  CHECK_THAT(c("ID"), Contains("FW, DMC4183 Rev 1.3h\r\nDMC, 4103, Rev 11\r\n") &&
                          Contains("EMULATED, trammel"));
  CHECK(c("MG _BN") == " 15953.0000\r\n:");
  CHECK(c("QZ") == " 8, 52, 26, 36\r\n:");
  const int a = c.galil.attach({"192.168.2.1", 49328}), b = c.galil.attach({"192.168.2.1", 5});
  CHECK_THAT(c("TH"), Contains("CONTROLLER IP ADDRESS 127,0,0,1 ETHERNET ADDRESS 00-50-4C-") &&
                          Contains(" IHA TCP PORT 23 TO IP ADDRESS 192,168,2,1 PORT 49328\r\n") &&
                          Contains(" IHC AVAILABLE\r\n"));
  c.galil.detach(a);
  CHECK(c.galil.attach({"192.168.2.1", 6}) == a);
  CHECK(b == 1);
  CHECK(c("IHT=>-1") == ":");
  CHECK(c("CW 1;CW ?") ==
        ":"
        " 1\r\n:");
  CHECK(c("EO 1") == ":");
  CHECK(c("TPA") == "TPA\r 0\r\n:");
  CHECK(c("EO 0") == "EO 0\r:");
}

TEST_CASE("the data record tells what the commands tell", "[emulate]") {
  Controller c;
  servo_on(c);
  c("SPA=16384;PAA=-40960;BGA");
  c.now_s = 1;
  c("bg");
  const std::string answer = c("QR");
  REQUIRE(answer.size() == 371);
  CHECK(answer.back() == ':');
  const auto byte = [&answer](std::size_t at) { return static_cast<std::uint8_t>(answer[at]); };
  const auto word = [&byte](std::size_t at) { return byte(at) | byte(at + 1) << 8; };
  const auto counts = [&answer](std::size_t at) {
    std::int32_t value = 0;
    std::memcpy(&value, answer.data() + at, sizeof value);
    return value;
  };
  CHECK(word(2) == 370);
  CHECK(word(4) == 1000);
  CHECK(byte(50) == 1);
  CHECK(counts(82 + 4) == c.number("RPA"));
  CHECK(counts(82 + 8) == c.number("TPA"));
  CHECK(counts(82 + 12) == c.number("TEA"));
  CHECK(counts(82 + 20) == 64 * c.number("TVA"));
  // Servo on, slewing, negative; PA, PA or PR, moving.
  CHECK(word(82) == ((1 << 5) | (1 << 7) | (1 << 13) | (1 << 14) | (1 << 15)));
  CHECK(byte(82 + 3) == 0);
  CHECK((word(82 + 3 * 36) & 1) == 1);  // D is off
  CHECK(byte(82 + 36 + 3) == 1);
}

TEST_CASE("TS of an axis that idles, servo on and off its limits, is 15", "[emulate]") {
  Controller c;
  servo_on(c);
  CHECK(c("TSA") == " 15\r\n:");
  c("MOA");
  CHECK(c("TSA") == " 47\r\n:");
  CHECK(c("MG _MOA,_MOB") == " 1.0000 0.0000\r\n:");
}

}  // namespace trammel::emulate

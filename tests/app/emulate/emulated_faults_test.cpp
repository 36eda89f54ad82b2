// Every fault once, counted, with the same exchange undisturbed beside it.

#include "app/emulate/faults.hpp"

#include "core/error.hpp"
#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

using tests::Client;
using tests::Controller;
using tests::EmulatedLaboratory;

namespace {

std::string prompts(Client& client, const std::string& lines, std::ptrdiff_t n) {
  client.send(lines);
  return client.receive(
      [n](const std::string& got) { return std::count(got.begin(), got.end(), ':') >= n; });
}

/// A controller whose rail A is sent to 81920 counts, with one fault or none.
struct Sent : Controller {
  explicit Sent(std::optional<FaultKind> kind, const std::string& first = "") {
    if (kind) faults.add({*kind, 2, ""});  // the first move goes undisturbed
    (*this)("SHABC;SPA=16384;SPB=16384");
    if (!first.empty()) (*this)(first);
    (*this)("PAA=100;BGA");
    now_s = 10;
    (*this)("PAA=81920;PAB=81920;BGAB");
  }
};

}  // namespace

TEST_CASE("a lost reply is a command carried out and not answered", "[emulate]") {
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab;
    if (struck) lab.stage_faults.add({FaultKind::lost_reply, 2, "PAA"});
    Client client(lab.stage_server.port());
    const std::string answers = prompts(client, "PAA=1\rPAA=4096\rPAA=?\r", struck ? 2 : 3);
    CHECK(answers == (struck ? ": 4096\r\n:" : ":: 4096\r\n:"));
    CHECK(lab.stage_faults.struck(FaultKind::lost_reply) == (struck ? 1 : 0));
  }
}

TEST_CASE("half a reply is half of the bytes, and the line goes on", "[emulate]") {
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab;
    if (struck) lab.stage_faults.add_next(FaultKind::half_reply, "SPA=?");
    Client client(lab.stage_server.port());
    const std::string answers = prompts(client, "SPA=12346\rSPA=?\rEO 0\r", struck ? 2 : 3);
    CHECK(answers == (struck ? ": 123:" : ": 12346\r\n::"));
    CHECK(lab.stage_faults.struck(FaultKind::half_reply) == (struck ? 1 : 0));
  }
}

TEST_CASE("a dropped connection has carried out the command", "[emulate]") {
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab;
    if (struck) lab.stage_faults.add_next(FaultKind::dropped, "PAA");
    Client client(lab.stage_server.port());
    CHECK(client.galil("PAA=4096") == (struck ? "" : ":"));
    CHECK(client.closed() == struck);
    Client again(lab.stage_server.port());
    CHECK(again.galil("PAA=?") == " 4096\r\n:");
    CHECK(lab.stage_faults.struck(FaultKind::dropped) == (struck ? 1 : 0));
  }
}

TEST_CASE("a broken beam fails one measurement and no other", "[emulate]") {
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab;
    if (struck) lab.tracker_faults.add({FaultKind::beam_break, 2, ""});
    Client client(lab.tracker_server.port());
    std::vector<std::string> codes;
    for (int k = 0; k < 3; ++k) {
      codes.push_back(client.tracker("!MEAS_SINGLE_POINT:A;PAIR;P1").substr(0, 7));
    }
    CHECK(codes == std::vector<std::string>{"ACK-300", struck ? "ERR-305" : "ACK-300", "ACK-300"});
    CHECK(lab.tracker_faults.struck(FaultKind::beam_break) == (struck ? 1 : 0));
  }
}

TEST_CASE("a lost beam is seen by the status at that moment", "[emulate]") {
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab;
    if (struck) lab.tracker_faults.add({FaultKind::beam_lost, 2, ""});
    Client client(lab.tracker_server.port());
    std::vector<std::string> codes;
    for (int k = 0; k < 3; ++k) codes.push_back(client.tracker("?STAT").substr(0, 7));
    CHECK(codes == std::vector<std::string>{"ACK-300", struck ? "ERR-338" : "ACK-300", "ACK-300"});
    CHECK(lab.tracker_faults.struck(FaultKind::beam_lost) == (struck ? 1 : 0));
  }
}

TEST_CASE("an unstable reading is marked and off by more than its noise", "[emulate]") {
  simulate::Truth truth = tests::emulated_truth();
  truth.temperature.rise_k = 0;
  std::vector<std::string> replies;
  for (const bool struck : {false, true}) {
    EmulatedLaboratory lab(truth);
    if (struck) lab.tracker_faults.add_next(FaultKind::unstable);
    Client client(lab.tracker_server.port());
    replies.push_back(client.tracker("!MEAS_SINGLE_POINT:A;BASE;B1"));
    CHECK_THAT(replies.back(), Contains(struck ? "False" : "True"));
    CHECK(lab.tracker_faults.struck(FaultKind::unstable) == (struck ? 1 : 0));
    CHECK_THAT(client.tracker("!MEAS_SINGLE_POINT:A;BASE;B1"), Contains("True"));
  }
  double calm[3] = {}, wild[3] = {};
  const char* form = "ACK-300 Single Point Measurement B1 result %lf,%lf,%lf";
  REQUIRE(std::sscanf(replies[0].c_str(), form, &calm[0], &calm[1], &calm[2]) == 3);
  REQUIRE(std::sscanf(replies[1].c_str(), form, &wild[0], &wild[1], &wild[2]) == 3);
  CHECK(std::hypot(calm[0] - wild[0], calm[1] - wild[1], calm[2] - wild[2]) > 0.05);
}

TEST_CASE("a limit hit stops one axis halfway, says so, and lets back", "[emulate]") {
  Sent struck(FaultKind::limit_hit), control(std::nullopt);
  for (Sent* c : {&struck, &control}) c->now_s = 30;
  CHECK(control("SCA;SCB;MG _LFA") == " 1\r\n: 1\r\n: 1.0000\r\n:");
  CHECK(struck("SCA;SCB;MG _LFA") == " 2\r\n: 1\r\n: 0.0000\r\n:");
  CHECK_THAT(struck.number("TPA"), WithinAbs(41000, 2000));
  CHECK(struck.code_after("BGA") == 22);
  CHECK(struck("PAA=0;BGA") == "::");
  struck.now_s = 60;
  CHECK(struck("SCA;TPA;MG _LFA") == " 1\r\n: 0\r\n: 1.0000\r\n:");
  CHECK(struck("PAA=81920;BGA") == "::");  // the switch is free again
  CHECK(struck.faults.struck(FaultKind::limit_hit) == 1);
}

TEST_CASE("an amplifier fault leaves one motor off halfway", "[emulate]") {
  Sent struck(FaultKind::amplifier_fault), control(std::nullopt);
  for (Sent* c : {&struck, &control}) c->now_s = 30;
  CHECK(control("SCA;MG _MOA,_MOB") == " 1\r\n: 0.0000 0.0000\r\n:");
  CHECK(struck("SCA;MG _MOA,_MOB") == " 15\r\n: 1.0000 0.0000\r\n:");
  CHECK(struck("SCB;TPB") == " 1\r\n: 81920\r\n:");
  CHECK_THAT(struck.number("TPA"), WithinAbs(41000, 500));
  CHECK(struck.number("TEA") == 0);
  CHECK((struck("QR")[52] & 1) == 1);
  CHECK(struck.code_after("BGA") == 20);
  struck("SHA;BGA");
  struck.now_s = 60;
  CHECK(struck("SCA;TPA") == " 1\r\n: 81920\r\n:");
  CHECK((struck("QR")[52] & 1) == 0);
}

TEST_CASE("a stall ends by off-on-error, or stays a following error", "[emulate]") {
  Sent with_oe(FaultKind::stall, "OEA=1;ERA=1000"), without(FaultKind::stall),
      control(std::nullopt, "OEA=1;ERA=1000");
  const double off_s = 10 + 1001.0 / 16384 + 0.5 * 16384.0 / 256000;
  with_oe.now_s = off_s - 0.002;
  CHECK(with_oe("SCA;MG _MOA") == " 0\r\n: 0.0000\r\n:");
  with_oe.now_s = off_s + 0.002;
  CHECK(with_oe("SCA;MG _MOA") == " 8\r\n: 1.0000\r\n:");
  for (Sent* c : {&with_oe, &without, &control}) c->now_s = 30;
  CHECK(with_oe("TPA;TEA;TPB") == " 100\r\n: 0\r\n: 81920\r\n:");
  CHECK(without("SCA;TPA;TEA") == " 1\r\n: 100\r\n: 81820\r\n:");
  CHECK((static_cast<int>(without.number("TSA")) & 0x40) != 0);  // error limit exceeded
  CHECK(control("SCA;TPA;TEA") == " 1\r\n: 81920\r\n: 0\r\n:");
  // Power off and on frees it.
  CHECK(without("MOA;SHA;TEA") == ":: 0\r\n:");
  without("BGA");
  without.now_s = 60;
  CHECK(without("TPA") == " 81920\r\n:");
}

TEST_CASE("faults are read from words, and unknown ones listed", "[emulate]") {
  const Fault fault = parse_fault("lost-reply@3:BG", Emulated::stage);
  CHECK(fault.kind == FaultKind::lost_reply);
  CHECK(fault.at == 3);
  CHECK(fault.only == "BG");
  CHECK(parse_fault("beam-break@1", Emulated::tracker).kind == FaultKind::beam_break);
  for (const char* wrong : {"beam-break@1", "stall", "stall@0", "stall@x", "flood@1", "@1", ""}) {
    CAPTURE(wrong);
    CHECK_THROWS_WITH(parse_fault(wrong, Emulated::stage),
                      Contains("amplifier-fault") && Contains("limit-hit"));
  }
  for (const FaultKind kind : {FaultKind::dropped, FaultKind::half_reply}) {
    CHECK(parse_fault(std::string(name_of(kind)) + "@1", Emulated::tracker).kind == kind);
  }
}

}  // namespace trammel::emulate

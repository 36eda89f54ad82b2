#include "app/device/galil_wire.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/scripted_server.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

constexpr double kConnectS = 10;
constexpr double kReplyS = 0.2;

struct Golden {
  const char* bytes;
  std::vector<GalilReply> replies;
};

// The forms of the protocol page: no data, a number with and without its sign place, refused,
// compound, ST's blank, MG's decimals, several lines, several values.
const std::vector<Golden>& golden() {
  static const std::vector<Golden> kGolden = {
      {":", {{true, ""}}},
      {" 51200\r\n:", {{true, "51200"}}},
      {"4\r\n:", {{true, "4"}}},
      {"-17\r\n:", {{true, "-17"}}},
      {"?", {{false, ""}}},
      {"::", {{true, ""}, {true, ""}}},
      {":500.0000\r\n:", {{true, ""}, {true, "500.0000"}}},
      {":?", {{true, ""}, {false, ""}}},
      {" :", {{true, ""}}},
      {" 20 Begin not valid with motor off\r\n:", {{true, "20 Begin not valid with motor off"}}},
      {"100, 200, 0, 0, 0, 0, 0, 0\r\n:", {{true, "100, 200, 0, 0, 0, 0, 0, 0"}}},
      {"FW, DMC4183 Rev 1.3h\r\nDMC, 4103, Rev 11\r\n:",
       {{true, "FW, DMC4183 Rev 1.3h\r\nDMC, 4103, Rev 11"}}},
      {" 1.0000\r\n: 0.0000\r\n: 0\r\n:", {{true, "1.0000"}, {true, "0.0000"}, {true, "0"}}},
  };
  return kGolden;
}

std::vector<GalilReply> all(GalilReplyCutter& cutter) {
  std::vector<GalilReply> replies;
  while (const auto reply = cutter.next()) replies.push_back(*reply);
  return replies;
}

void check_same(const std::vector<GalilReply>& got, const std::vector<GalilReply>& expected) {
  REQUIRE(got.size() == expected.size());
  for (std::size_t k = 0; k < got.size(); ++k) {
    CHECK(got[k].accepted == expected[k].accepted);
    CHECK(got[k].value == expected[k].value);
  }
}

/// A controller on which EO and CW work.
std::unique_ptr<tests::ScriptedServer> controller() {
  auto server = std::make_unique<tests::ScriptedServer>("\r");
  server->on("EO 0", ":");
  server->on("CW 1", ":");
  server->otherwise([](const std::string&) { return "?"; });
  server->on("TC1", " 1 Unrecognized command\r\n:");
  return server;
}

}  // namespace

TEST_CASE("an answer is the same wherever the network cuts it", "[device][galil]") {
  for (const Golden& g : golden()) {
    const std::string bytes = g.bytes;
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      CAPTURE(bytes, cut);
      GalilReplyCutter cutter;
      std::vector<GalilReply> got;
      cutter.feed(bytes.substr(0, cut));
      for (const GalilReply& reply : all(cutter)) got.push_back(reply);
      cutter.feed(bytes.substr(cut));
      for (const GalilReply& reply : all(cutter)) got.push_back(reply);
      check_same(got, g.replies);
      CHECK(cutter.rest().empty());
    }
  }
}

TEST_CASE("text of a program in the controller is no part of an answer", "[device][galil]") {
  GalilReplyCutter cutter;
  std::string said = "hello:\r\n?";
  for (char& byte : said) byte = static_cast<char>(byte | '\x80');
  cutter.feed(said.substr(0, 3) + " 51" + said.substr(3) + "200\r\n:");
  check_same(all(cutter), {{true, "51200"}});
  CHECK(cutter.take_unsolicited() == "hello:\r\n?");
  CHECK(cutter.take_unsolicited().empty());
}

TEST_CASE("a refusal names the command and what TC1 says", "[device][galil]") {
  const auto server = controller();
  server->on("BGA", "?");
  server->on("TC1", " 20 Begin not valid with motor off\r\n:");
  GalilWire wire({"127.0.0.1", server->port()}, kConnectS, kReplyS);
  try {
    wire.command("BGA");
    FAIL("BG was taken");
  } catch (const GalilRefusal& refused) {
    CHECK(refused.code == 20);
    CHECK(refused.text().where.field == "BGA");
    CHECK(refused.text().got == "20 Begin not valid with motor off");
  }
  server->on("SHA", ":");
  CHECK(wire.command("SHA").empty());  // still in step
}

TEST_CASE("questions in one line get one answer each", "[device][galil]") {
  const auto server = controller();
  server->on("MG _BGA;TPA;SCA", " 1.0000\r\n:-40960\r\n: 0\r\n:");
  GalilWire wire({"127.0.0.1", server->port()}, kConnectS, kReplyS);
  CHECK(wire.ask_numbers("MG _BGA;TPA;SCA") == std::vector<double>{1, -40960, 0});
  server->on("TPA;TPB", " 2147483647\r\n:-2147483648\r\n:");
  CHECK(wire.ask_numbers("TPA;TPB") == std::vector<double>{2147483647, -2147483648});
}

TEST_CASE("what is no whole answer in time is a lost one", "[device][galil]") {
  struct Loss {
    tests::Answer answer;
    LinkError::Kind kind;
    const char* word;
  };
  for (const Loss& loss : {Loss{{""}, LinkError::Kind::silent, "no answer"},
                           {{" 409"}, LinkError::Kind::silent, "half"},
                           {{" 40960\r\n:"}, LinkError::Kind::silent, "half"},
                           {{" 40960\r\n: 7\r\n"}, LinkError::Kind::silent, "half"},
                           {{"", true}, LinkError::Kind::closed, "closed"},
                           {{" 409", true}, LinkError::Kind::closed, "half"},
                           {{"what?\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{" 1e308\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{" 4294967296\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{" 2147483648\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{"-2147483649\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{"-\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{"nan\r\n:1\r\n:"}, LinkError::Kind::nonsense, "no number"},
                           {{"?"}, LinkError::Kind::nonsense, "refuses"}}) {
    CAPTURE(loss.answer.bytes, loss.answer.close);
    const auto server = controller();
    server->on("TPA;TPB", {loss.answer});
    GalilWire wire({"127.0.0.1", server->port()}, kConnectS, kReplyS);
    try {
      static_cast<void>(wire.ask_numbers("TPA;TPB"));
      FAIL("an answer was made up");
    } catch (const LinkError& error) {
      if (loss.answer.bytes != " 40960\r\n:") {
        CHECK_THAT(error.what(), Catch::Matchers::Contains(loss.word));
      }
      CHECK(error.kind == loss.kind);
    }
    CHECK_FALSE(wire.alive());
    CHECK_THROWS_AS(wire.command("SHA"), LinkError);  // never again over this line
  }
}

TEST_CASE("an answer that comes too late is not taken for the next one", "[device][galil]") {
  const auto server = controller();
  server->on("TPA", " 1\r\n: 2\r\n:");  // one more than asked for
  server->on("TPB", " 3\r\n:");
  GalilWire wire({"127.0.0.1", server->port()}, kConnectS, kReplyS);
  CHECK(wire.ask_numbers("TPA") == std::vector<double>{1});
  CHECK_FALSE(wire.alive());
  CHECK_THROWS_AS(wire.ask_numbers("TPB"), LinkError);
}

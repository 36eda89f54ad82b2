// Exchanges as the protocols state them, byte by byte, over a socket.

#include <array>

#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

using tests::Client;
using tests::EmulatedLaboratory;

TEST_CASE("a Galil's session from power-up to a refused begin, byte by byte", "[emulate]") {
  EmulatedLaboratory lab;
  Client client(lab.stage_server.port());
  for (const char* line : {"EO 0", "SHA", "SPA=10666", "PAA=40960", "BGA"}) {
    CAPTURE(line);
    CHECK(client.galil(line) == ":");
  }
  std::string code = client.galil("SCA");
  while (code == " 0\r\n:") code = client.galil("SCA");
  CHECK(code == " 1\r\n:");
  client.until_at_rest("A");
  CHECK(client.galil("TPA") == " 40960\r\n:");
  CHECK(client.galil("MOA") == ":");
  CHECK(client.galil("BGA") == "?");
  CHECK(client.galil("TC1") == " 20 Begin not valid with motor off\r\n:");
}

TEST_CASE("a Galil answers one prompt for each sub-command", "[emulate]") {
  EmulatedLaboratory lab;
  Client client(lab.stage_server.port());
  CHECK(client.galil("a=1;b=2", 2) == "::");
  CHECK(client.galil("MG a,b") == " 1.0000 2.0000\r\n:");
  CHECK(client.galil("DM speed[2]") == ":");
  CHECK(client.galil("speed[0]=500;MG speed[0]", 2) == ": 500.0000\r\n:");
  CHECK(client.galil("bg") == "?");
  CHECK(client.galil("TC1") == " 1 Unrecognized command\r\n:");
  CHECK(client.galil("\x12\x16") == "DMC4183 Rev 1.3h\r\n:");
  CHECK(client.galil("DPA=100;DPB=200;TP", 3) == ":: 100, 200, 0, 0, 0, 0, 0, 0\r\n:");
  CHECK(client.galil("QZ") == " 8, 52, 26, 36\r\n:");
}

TEST_CASE("a Galil's lines are framed by CR, with or without LF, in any packets", "[emulate]") {
  EmulatedLaboratory lab;
  Client client(lab.stage_server.port());
  client.send("SPA=2000\r\nSPB=3000\rSP ");
  client.send("?,");
  client.send("?\r\n");
  const auto three_prompts = [](const std::string& got) {
    return std::count(got.begin(), got.end(), ':') == 3;
  };
  CHECK(client.receive(three_prompts) == ":: 2000, 3000\r\n:");
  const std::string eighty = "MG 1;" + std::string(75, ' ');
  CHECK(client.galil(eighty, 2) == " 1.0000\r\n::");
  CHECK(client.galil(eighty + ";MG 2") == "?");
  CHECK(client.galil("TC1") == " 5 Input buffer full\r\n:");
}

TEST_CASE("eight handles are listed, the ninth client is refused", "[emulate]") {
  EmulatedLaboratory lab;
  std::vector<std::unique_ptr<Client>> clients;
  for (int k = 0; k < 8; ++k) {
    clients.push_back(std::make_unique<Client>(lab.stage_server.port()));
    CHECK(clients.back()->galil("EO 0") == ":");
  }
  const std::string handles = clients[0]->galil("TH", 1);
  CHECK(handles.find("AVAILABLE") == std::string::npos);
  CHECK_THAT(handles, Contains(" IHH TCP PORT 23 TO IP ADDRESS 127,0,0,1 PORT "));
  Client ninth(lab.stage_server.port());
  CHECK(ninth.galil("EO 0").empty());
  CHECK(ninth.closed());
}

TEST_CASE("a tracker answers in its grammar", "[emulate]") {
  EmulatedLaboratory lab;
  Client client(lab.tracker_server.port());
  CHECK(client.tracker("?STAT") == "ACK-300 READY (Trammel emulator)\r\n");
  CHECK(client.tracker("?LSTA") == "ACK-300 LON\r\n");
  const std::string point = client.tracker("!MEAS_SINGLE_POINT:A;BASE;B1");
  CHECK_THAT(point, Catch::Matchers::Matches(
                        "ACK-300 Single Point Measurement B1 result "
                        "-?[0-9]+\\.[0-9]{6},-?[0-9]+\\.[0-9]{6},-?[0-9]+\\.[0-9]{6} "
                        "[0-9]{2}/[0-9]{2}/[0-9]{4} [0-9]{2}:[0-9]{2}:[0-9]{2} True\r\n"));
  CHECK(client.tracker("!CMDEXE:PLATFORM") == "ACK-106 Successfully ran CMD PLATFORM\r\n");
  CHECK(client.tracker("?POS PLATFORM").starts_with("ACK-300 Object Offset Report FramePLATFORM_"));
  const std::string offset = client.tracker("?OFFSET:PLATFORM;BASE");
  CHECK_THAT(offset, Catch::Matchers::Matches(
                         "ACK-300 Object Offset Report FramePLATFORM_1;X:-?[0-9.]+;Y:-?[0-9.]+;"
                         "Z:-?[0-9.]+;Rx:-?[0-9.]+;Ry:-?[0-9.]+;Rz:-?[0-9.]+;"
                         "[0-9]{2}/[0-9]{2}/[0-9]{4} [0-9]{2}:[0-9]{2}:[0-9]{2}\r\n"));
  struct Row {
    const char* line;
    const char* code;
  };
  for (const Row& row : std::vector<Row>{{"hello", "ERR-200 "},
                                         {"!MEAS_SINGLE_POINT:A;BASE", "ERR-200 "},
                                         {"!LST:2", "ERR-200 "},
                                         {"!MEAS_SINGLE_POINT:A;BASE;B9", "ERR-306 "},
                                         {"!CMDEXE:NOBODY", "ERR-306 "},
                                         {"?POS BASE", "ERR-306 "},
                                         {"?OFFSET:PAIR;BASE", "ERR-340 "},
                                         {"?OFFSET:BASE;PLATFORM", "ERR-306 "}}) {
    CAPTURE(row.line);
    CHECK(client.tracker(row.line).starts_with(row.code));
  }
  CHECK(client.tracker("!LST:0") == "ACK-300 OK\r\n");
  CHECK(client.tracker("?LSTA") == "ACK-300 LOFF\r\n");
  CHECK(client.tracker("!MEAS_SINGLE_POINT:A;BASE;B1").starts_with("ERR-338 "));
}

}  // namespace trammel::emulate

#include "app/session/lock.hpp"

#include <unistd.h>

#include <memory>

#include "core/error.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

TEST_CASE("one controller has one runner, whatever its host is called", "[session]") {
  auto first = std::make_unique<ControllerLock>("127.0.0.1:47999");
  const ControllerLock other("127.0.0.1:47998");  // another port is another controller
  for (const char* same : {"127.0.0.1:47999", "localhost:47999"}) {
    CAPTURE(same);
    CHECK_THROWS_WITH(ControllerLock(same), Contains("driven already") &&
                                                Contains("process " + std::to_string(::getpid())));
  }
  first.reset();
  CHECK_NOTHROW(ControllerLock("localhost:47999"));
}

TEST_CASE("two databases do not drive one controller", "[session][sockets]") {
  SocketCampaign campaign(small_plan());
  {
    const ControllerLock elsewhere("127.0.0.1:" + std::to_string(campaign.lab.stage_server.port()));
    CHECK_THROWS_WITH(campaign.run(), Contains("driven already"));
    CHECK(campaign.lab.log.lines().empty());  // not a word to the controller
  }
  CHECK(campaign.run().state == State::done);
}

TEST_CASE("a link to a database is no second database", "[session]") {
  const TemporaryFolder folder;
  const auto file = folder.write("t.db", "");
  std::filesystem::create_symlink(file, folder.path() / "link.db");
  const CampaignLock lock(file, "u");
  CHECK_THROWS_WITH(CampaignLock(folder.path() / "link.db", "u"), Contains("measured already"));
  CHECK(CampaignLock::holder(folder.path() / "link.db", "u") == ::getpid());
  CHECK_NOTHROW(CampaignLock(folder.path() / "link.db", "v"));
}

}  // namespace trammel::session

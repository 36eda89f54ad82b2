#include "app/archive/heart.hpp"

#include <chrono>

namespace trammel::archive {

Heart::Heart(Connect connect, double lease_s)
    : connect_(std::move(connect)),
      lease_s_(lease_s),
      thread_([this](const std::stop_token& ended) { beat(ended); }) {}

void Heart::add(const Claim& claim) {
  const std::scoped_lock lock(mutex_);
  claims_.emplace(claim.token, claim);
}

void Heart::remove(const Claim& claim) {
  const std::scoped_lock lock(mutex_);
  claims_.erase(claim.token);
}

void Heart::for_each_claim(const std::function<void(Link&, const Claim&)>& what) {
  std::map<std::string, Claim> claims;
  {
    const std::scoped_lock lock(mutex_);
    claims = claims_;
  }
  if (claims.empty()) return;
  const auto link = connect_();
  for (const auto& [token, claim] : claims) what(*link, claim);
}

void Heart::release_all() {
  for_each_claim([](Link& link, const Claim& claim) {
    link.ask("SELECT trammel.give_back($1, $2, '')", {claim.id, claim.token});
  });
}

void Heart::beat(const std::stop_token& ended) {
  const auto third = std::chrono::duration<double>(lease_s_ / 3);
  std::mutex alone;
  std::unique_lock lock(alone);
  while (!wake_.wait_for(lock, ended, third, [] { return false; }) && !ended.stop_requested()) {
    try {
      for_each_claim([this](Link& link, const Claim& claim) {
        link.ask("SELECT trammel.heartbeat($1, $2, $3)",
                 {claim.id, claim.token, std::to_string(lease_s_)});
      });
    } catch (const Error&) {  // the next beat tries again
    }
  }
}

}  // namespace trammel::archive

#pragma once
// A file of tracker points, its layout and the plan that was measured -> a campaign.

#include <map>
#include <string>
#include <vector>

#include "app/files/campaign_file.hpp"
#include "app/files/points_poses.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

struct PointsCampaign {
  CampaignFile file;
  std::map<int, std::string> raw_reply;  // the lines a reading was made of, by seq
  PointsPoses poses;                     // with all that was left out, by line
  double height_spread_mm = 0;           // largest - smallest height of the platform over the plane
  double out_of_plane_mm = 0;            // largest of any pose
  double rms_mm = 0;                     // rms of the in-plane residuals of all poses
  std::string started = {};              // the tracker's clock at the first row, where it has one
};

/// Every pose that is ok makes a reading. Commands are those of the nominal robot at the target,
/// `from` is as the plan moves; time counts from the first row. The campaign's tracker sigmas are
/// those of a pose of all nests.
/// @throws InputError  as poses_of_points; dates that can be read two ways; a target out of reach;
///                     nothing left
/// Proof: points_campaign_test.cpp.
PointsCampaign campaign_of_points(const PointsFile& file, const Layout& layout,
                                  const Mechanism& mechanism, const Plan& plan);

}  // namespace trammel

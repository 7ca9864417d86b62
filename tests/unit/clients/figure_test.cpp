#include "clients/stylemon/figure.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/clients/fake_daemon.h"

namespace styled::stylemon {
namespace {

using client::Transform;

constexpr int kColumns = 40, kRows = 24;

struct Standing {
  v1::Body body = client::HumanoidBody("rig.a", v1::OUTPUT_RIG, 3);
  Anatomy anatomy = Analyse(body);
  body::Pose pose;
  std::vector<Transform> joints;

  Standing() { Update(); }
  void Update() {
    EXPECT_EQ(WorldTransforms(body, client::HumanoidFrame(body, pose, 1), joints),
              client::FrameError::kNone);
  }
  Pose Look(Side side = Side::kFront) const {
    Pose look;
    look.anatomy = &anatomy;
    look.joints = &joints;
    look.side = side;
    look.height = PictureHeight(anatomy, 0);
    return look;
  }
};

std::string Picture(const Pose& pose) {
  Canvas canvas(kColumns, kRows, true);
  Draw(pose, {0, 0, 2 * kColumns, 4 * kRows}, canvas);
  std::string out;
  for (int row = 0; row < canvas.rows(); ++row) out += canvas.RowText(row) + "\n";
  return out;
}

// Cells of an ink, as {lowest column, highest column, lowest row, highest row}; count 0 if none.
struct Extent {
  int count = 0, left = 999, right = -1, top = 999, bottom = -1;
};
Extent Find(const Pose& pose, Ink ink) {
  Canvas canvas(kColumns, kRows, true);
  Draw(pose, {0, 0, 2 * kColumns, 4 * kRows}, canvas);
  Extent extent;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      if (canvas.At(column, row).glyph == U' ' || canvas.At(column, row).ink != ink) continue;
      ++extent.count;
      extent.left = std::min(extent.left, column);
      extent.right = std::max(extent.right, column);
      extent.top = std::min(extent.top, row);
      extent.bottom = std::max(extent.bottom, row);
    }
  }
  return extent;
}

TEST(Anatomy, ReadsTheHumanoid) {
  const Standing figure;
  EXPECT_EQ(figure.anatomy.joint[body::kHead], int{body::kHead});
  EXPECT_EQ(figure.anatomy.inks[body::kLeftFoot], Ink::kLeft);
  EXPECT_EQ(figure.anatomy.inks[body::kRightHand], Ink::kRight);
  EXPECT_EQ(figure.anatomy.inks[body::kChest], Ink::kCentre);
  EXPECT_NEAR(figure.anatomy.height, 1.65F, 0.1F);
}

TEST(Anatomy, AFingerHasTheInkOfItsHandAndUnknownNamesAreDrawnAll) {
  v1::Body body = client::HumanoidBody("rig.a", v1::OUTPUT_RIG, 3);
  body.add_names("leftIndexProximal");
  body.add_parents(body::kLeftHand);
  for (int axis = 0; axis < 3; ++axis) body.add_offsets(0.02F);
  EXPECT_EQ(Analyse(body).inks.back(), Ink::kLeft);

  for (int joint = 0; joint < body.names_size(); ++joint) {
    body.set_names(joint, "q" + std::to_string(joint));
  }
  const Anatomy anatomy = Analyse(body);
  EXPECT_EQ(anatomy.height, 0.0F);
  for (const Ink ink : anatomy.inks) EXPECT_EQ(ink, Ink::kCentre);
  float yaw = 7;
  EXPECT_FALSE(Facing(anatomy, std::vector<Transform>(22), yaw));
  EXPECT_EQ(yaw, 7.0F);
  EXPECT_EQ(PictureHeight(anatomy, 1.3F), 1.3F);
}

TEST(PictureHeight, IsTheSameForPeopleAndFollowsTheUnit) {
  Anatomy anatomy;
  anatomy.height = 1.5F;
  anatomy.metres_per_unit = 1;
  EXPECT_FLOAT_EQ(PictureHeight(anatomy, 0), 1.75F);
  anatomy.height = 150;
  anatomy.metres_per_unit = 0.01F;
  EXPECT_FLOAT_EQ(PictureHeight(anatomy, 0), 175.0F);
  anatomy.metres_per_unit = 0;
  EXPECT_FLOAT_EQ(PictureHeight(anatomy, 0), 150.0F);
  anatomy.metres_per_unit = 1;  // 150 metres: the unit is wrong
  EXPECT_FLOAT_EQ(PictureHeight(anatomy, 0), 150.0F);
}

TEST(Facing, FollowsTheBody) {
  Standing figure;
  for (const float angle : {0.0F, 0.5F, 2.0F, -3.0F}) {
    figure.pose.rotations[body::kHips] = body::Quat(Eigen::AngleAxisf(angle, body::Vec3::UnitY()));
    figure.Update();
    float yaw = 0;
    ASSERT_TRUE(Facing(figure.anatomy, figure.joints, yaw));
    EXPECT_NEAR(yaw, angle, 1e-3F);
  }
}

TEST(Draw, TheFrontViewHasTheLeftOnTheRightAndHandsSpread) {
  const Standing figure;
  const Extent left = Find(figure.Look(), Ink::kLeft), right = Find(figure.Look(), Ink::kRight);
  EXPECT_GT(left.right, kColumns / 2 + 6);
  EXPECT_LT(right.left, kColumns / 2 - 6);
  EXPECT_GE(left.left, kColumns / 2 - 1);
  EXPECT_LE(right.right, kColumns / 2);
  const Extent centre = Find(figure.Look(), Ink::kCentre);
  EXPECT_LT(centre.top, 8) << "the head is in the upper part";
  EXPECT_GE(centre.top, 1) << "with room above";
}

TEST(Draw, TheSideViewIsNarrowAndFacesRight) {
  const Standing figure;
  const Extent right = Find(figure.Look(Side::kSide), Ink::kRight);
  EXPECT_LT(right.right - right.left, 6);
  EXPECT_GT(right.right, kColumns / 2) << "the toes point to the right";
}

TEST(Draw, TheFloorIsUnderTheFeetAndAtTheLowerEdge) {
  Standing figure;
  const Extent floor = Find(figure.Look(), Ink::kFloor);
  EXPECT_EQ(floor.bottom, kRows - 1);
  EXPECT_EQ(floor.left, 0);
  EXPECT_EQ(floor.right, kColumns - 1);
  EXPECT_GE(Find(figure.Look(), Ink::kRight).bottom, kRows - 2);
  figure.pose.hips_position_m.y() += 0.4F;  // a jump leaves the floor where it is
  figure.Update();
  EXPECT_EQ(Find(figure.Look(), Ink::kFloor).top, floor.top);
  EXPECT_LT(Find(figure.Look(), Ink::kRight).bottom, kRows - 4);
}

TEST(Draw, WalkingMovesTheMarksAndNotTheFigure) {
  Standing figure;
  const std::string here = Picture(figure.Look(Side::kSide));
  figure.pose.hips_position_m.x() += 5;
  figure.pose.hips_position_m.z() -= 300;
  figure.Update();
  EXPECT_EQ(Picture(figure.Look(Side::kSide)), here);
  Pose moved = figure.Look(Side::kSide);
  moved.travel = 0.1F;
  EXPECT_NE(Picture(moved), here);
}

TEST(Draw, ATurnedBodySeenFromItsOwnSideLooksTheSame) {
  Standing figure;
  const std::string straight = Picture(figure.Look(Side::kSide));
  figure.pose.rotations[body::kHips] =
      body::Quat(Eigen::AngleAxisf(std::numbers::pi_v<float> / 2, body::Vec3::UnitY()));
  figure.Update();
  Pose look = figure.Look(Side::kSide);
  EXPECT_NE(Picture(look), straight);
  ASSERT_TRUE(Facing(figure.anatomy, figure.joints, look.yaw_rad));
  EXPECT_EQ(Picture(look), straight);
}

TEST(Draw, CentimetresLookLikeMetres) {
  Standing metres, centimetres;
  v1::Body& body = centimetres.body;
  for (int i = 0; i < body.offsets_size(); ++i) body.set_offsets(i, body.offsets(i) * 100);
  body.set_metres_per_unit(0.01F);
  centimetres.anatomy = Analyse(body);
  centimetres.pose.hips_position_m *= 100;
  centimetres.Update();
  EXPECT_EQ(Picture(centimetres.Look()), Picture(metres.Look()));
}

TEST(Draw, ContactsAreMarkedUnderTheirFoot) {
  const Standing figure;
  Pose look = figure.Look();
  EXPECT_EQ(Find(look, Ink::kContact).count, 0);
  look.contacts = 1;
  EXPECT_GT(Find(look, Ink::kContact).left, kColumns / 2 - 1) << "left foot, on the right";
  look.contacts = 2;
  EXPECT_LT(Find(look, Ink::kContact).right, kColumns / 2 + 1);
}

TEST(Draw, AbsurdAreasAndHeightsDrawNothing) {
  const Standing figure;
  Canvas canvas(10, 10, true);
  Draw(figure.Look(), {0, 0, 2, 2}, canvas);
  Pose look = figure.Look();
  look.height = 0;
  Draw(look, {0, 0, 20, 40}, canvas);
  look.height = std::numeric_limits<float>::quiet_NaN();
  Draw(look, {0, 0, 20, 40}, canvas);
  for (int row = 0; row < 10; ++row) EXPECT_EQ(canvas.RowText(row), "");
}

}  // namespace
}  // namespace styled::stylemon

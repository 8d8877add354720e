#include <gtest/gtest.h>

#include "scene_mistakes.hpp"

namespace test_validate_contacts {

// As in test_validate.cpp: contacts and loads.

using namespace physics;
using mistakes::good_scene;
using mistakes::infinity;
using mistakes::message;
using mistakes::nan;

TEST(Validate, NamesAWrongBodyOfAContact) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].body = world)), "contact 'rim': body is the world, which nothing moves");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].body.index = 9)),
            "contact 'rim': body 9 is not a body (the scene has 2, counted from 0)");
}

TEST(Validate, NamesAWrongPlane) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].normal.setZero())), "contact 'rim': normal has length 0");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].normal = Vec3(0, 0, 2))),
            "contact 'rim': normal (0, 0, 2) has length 2, not 1");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].plane_point.y() = nan)),
            "contact 'rim': plane point (0, nan, 0) is not finite");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].point.y() = nan)), "contact 'rim': point (0, nan, 0) is not finite");
}

TEST(Validate, NamesAWrongFriction) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].friction = -0.1)), "contact 'rim': friction -0.1 is not >= 0");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].friction = nan)), "contact 'rim': friction nan is not >= 0");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].friction = infinity)), "contact 'rim': friction inf is not finite");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].friction = 1e300)),
            "contact 'rim': friction 1e+300 is above 1000, where nothing slides any more and solves fail");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].friction = 1000)), "");
}

TEST(Validate, WantsAnEvenNumberOfDirections) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].directions = 5)),
            "contact 'rim': directions 5 is not an even number from 4 to 1024");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].directions = 2)),
            "contact 'rim': directions 2 is not an even number from 4 to 1024");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].directions = 1026)),
            "contact 'rim': directions 1026 is not an even number from 4 to 1024");
}

TEST(Validate, NamesATangentWithoutADirectionInThePlane) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].tangent->setZero())), "contact 'rim': tangent has length 0");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].tangent = Vec3(0, 0, -3))),
            "contact 'rim': tangent (0, 0, -1) is parallel to the normal (0, 0, 1)");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].tangent->x() = nan)), "contact 'rim': tangent (nan, 0, 0) is not finite");
}

TEST(Validate, TurnsATangentIntoThePlane) {
  Mechanism scene = good_scene();
  scene.contacts[0].tangent = Vec3(3, 4, 7);
  validate(scene);
  EXPECT_TRUE(scene.contacts[0].tangent->isApprox(Vec3(0.6, 0.8, 0), 1e-15));
}

TEST(Validate, NamesAWrongRadiusOfAContact) {
  EXPECT_EQ(message(CHANGE(scene.contacts[0].radius = -1)), "contact 'rim': radius -1 is not >= 0");
}

TEST(Validate, NamesAWrongLoad) {
  EXPECT_EQ(message(CHANGE(scene.loads[0].body = world)), "load 0: body is the world, which nothing moves");
  EXPECT_EQ(message(CHANGE(scene.loads[0].body.index = 2)),
            "load 0: body 2 is not a body (the scene has 2, counted from 0)");
  EXPECT_EQ(message(CHANGE(scene.loads[0].first_step = 0)),
            "load 0: first step 0 is not >= 1 (step 1 leads to record 1)");
  EXPECT_EQ(message(CHANGE(scene.loads[0].first_step = 5)), "load 0: last step 1 is before the first step 5");
  EXPECT_EQ(message(CHANGE(scene.loads[0].force.x() = nan)), "load 0: force (nan, 0, 0) is not finite");
  EXPECT_EQ(message(CHANGE(scene.loads[0].torque.x() = nan)), "load 0: torque (nan, 0, 0) is not finite");
}

}  // namespace test_validate_contacts

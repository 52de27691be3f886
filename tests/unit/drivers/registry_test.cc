#include "drivers/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapticd {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Registry, EmptyMeansTheSimulatorWhenThereIsNoHardware) {
  const auto found = findDevices();
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back().info.uri, "sim://default");
  EXPECT_FALSE(found.back().real);
  Result<std::unique_ptr<Device>> device = makeDevice("");
  ASSERT_TRUE(device.ok());
  if (!found.front().real) {
    EXPECT_EQ((*device)->info().uri, "sim://default");
  }
}

TEST(Registry, CanonicalUriAndSerialOpenTheSameDevice) {
  Result<std::unique_ptr<Device>> a = makeDevice("sim://default?radius=0.030&motion=circle&mass=0.2");
  ASSERT_TRUE(a.ok()) << toString(a.error());
  EXPECT_EQ((*a)->info().uri, "sim://default?motion=circle");
  Result<std::unique_ptr<Device>> b = makeDevice((*a)->info().uri);
  ASSERT_TRUE(b.ok());
  EXPECT_EQ((*a)->info().serial, (*b)->info().serial);

  Result<std::unique_ptr<Device>> c = makeDevice(findDevices().back().info.serial);
  ASSERT_TRUE(c.ok()) << toString(c.error());
  EXPECT_EQ((*c)->info().uri, "sim://default");
}

TEST(Registry, TwoSimulatorsAreTwoDevices) {
  Result<std::unique_ptr<Device>> a = makeDevice("sim://default?serial=left");
  Result<std::unique_ptr<Device>> b = makeDevice("sim://default?serial=right");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE((*a)->info().uri, (*b)->info().uri);
  EXPECT_EQ((*a)->info().serial, "left");
}

TEST(Registry, ZeroOfADeviceWithoutForcesDoesNothingAndOfNoDeviceIsRefused) {
  EXPECT_TRUE(zeroDevice("sim://default").ok());
  EXPECT_EQ(zeroDevice("smi://default").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(zeroDevice("default").error().code, ErrorCode::kInvalidArgument);
}

TEST(Registry, UnknownSchemeListsTheKnownOnes) {
  Result<std::unique_ptr<Device>> device = makeDevice("smi://default");
  ASSERT_FALSE(device.ok());
  EXPECT_EQ(device.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(toString(device.error()), HasSubstr("sim://PRESET"));
}

TEST(Registry, UnknownSerialListsWhatThereIs) {
  Result<std::unique_ptr<Device>> device = makeDevice("no-such-serial");
  ASSERT_FALSE(device.ok());
  EXPECT_EQ(device.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(toString(device.error()), HasSubstr("sim://default"));
  EXPECT_THAT(toString(device.error()), Not(HasSubstr("did you mean")));
}

TEST(Registry, WhoLeavesTheSlashesAwayOrMistypesASchemeIsTold) {
  EXPECT_THAT(toString(makeDevice("falcon").error()), HasSubstr("did you mean falcon://"));
  EXPECT_THAT(toString(makeDevice("flacon").error()), HasSubstr("did you mean falcon://"));
  EXPECT_THAT(toString(makeDevice("spacemose://default").error()), HasSubstr("did you mean spacemouse://"));
  EXPECT_THAT(toString(makeDevice("sam").error()), HasSubstr("did you mean sim://"));
}

TEST(Registry, SchemesOfTheThesisAreUnsupportedAndSayWhy) {
  for (const char* uri : {"remote://host/device0", "phantom://default?mode=direct", "ehap://grab/left"}) {
    Result<std::unique_ptr<Device>> device = makeDevice(uri);
    ASSERT_FALSE(device.ok()) << uri;
    EXPECT_EQ(device.error().code, ErrorCode::kUnsupported);
    EXPECT_FALSE(device.error().what.empty());
    EXPECT_FALSE(device.error().remedy.empty());
  }
}

TEST(Registry, WrongQueriesNameTheKeyAndTheRemedy) {
  struct Case {
    const char* uri;
    const char* says;
  };
  for (const Case& c :
       {Case{"sim://default?hand_stifness=400", "did you mean \"hand_stiffness\"?"},
        Case{"sim://default?mass=0", "a number from 0.005 to 10 kg"},
        Case{"sim://default?mass=10.1", "a number from 0.005 to 10 kg"},
        Case{"sim://default?delay=65", "an integer from 0 to 64 periods"},
        Case{"sim://default?centre=0,0,1.5", "from -1 to 1 m"}, Case{"sim://default?mass=nan", "key mass"},
        Case{"sim://default?mass=0.2kg", "\"0.2kg\" does not fit"},
        Case{"sim://default?motion=circel", "did you mean circle?"},
        Case{"sim://default?centre=1,2", "three numbers x,y,z"},
        Case{"sim://default?delay=1.5", "an integer from 0 to 64 periods"}, Case{"sim://default?dof=4", "3 or 6"},
        Case{"sim://default?loop=maybe", "0 or 1"}, Case{"sim://default?lower=0,0,0&upper=0,0,0", "workspace is empty"},
        Case{"sim://default?motion=csv", "needs a file"}, Case{"sim://default?file=/tmp/x.csv", "add motion=csv"},
        Case{"sim://default?zzz=1", "known keys: rate, mass"}, Case{"sim://defualt", "did you mean sim://default?"}}) {
    Result<std::unique_ptr<Device>> device = makeDevice(c.uri);
    ASSERT_FALSE(device.ok()) << c.uri;
    EXPECT_THAT(toString(device.error()), HasSubstr(c.says)) << c.uri;
  }
}

TEST(Registry, HardwareIsTheSameHoweverItIsDriven) {
  EXPECT_TRUE(isAskedFor("falcon://EMU1", "falcon://EMU1"));
  EXPECT_TRUE(isAskedFor("falcon://EMU1?counts_per_nm=12000", "falcon://EMU1"));
  EXPECT_FALSE(isAskedFor("falcon://EMU1", "falcon://EMU1?counts_per_nm=12000")) << "it is not driven so";
  EXPECT_FALSE(isAskedFor("falcon://EMU1?centre_z=0.1", "falcon://EMU1?counts_per_nm=12000"));
  EXPECT_FALSE(isAskedFor("falcon://EMU12?centre_z=0.1", "falcon://EMU1"));
  EXPECT_FALSE(isAskedFor("sim://default?mass=0.3", "sim://default")) << "a simulator of other mass is another";
  EXPECT_FALSE(isAskedFor("hidpid://default?max_force=3&path=/dev/hidraw2", "hidpid://default"));
  EXPECT_FALSE(isAskedFor("woodyhid://polhem_v3?serial=W2", "woodyhid://polhem_v3"));
  EXPECT_TRUE(isAskedFor("woodyhid://polhem_v3?gravity=0.3", "woodyhid://polhem_v3"));
  EXPECT_FALSE(isAskedFor("falcon://EMU1?centre_z=0.1", ""));
}

}  // namespace
}  // namespace hapticd

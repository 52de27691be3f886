// Large meshes that the control thread neither copies nor unmaps itself.
#include "daemon/scene/mesh/mesh_store.h"

#include <fstream>
#include <string>

#include "daemon/builder/build.h"
#include "tests/support/eventually.h"
#include "tests/support/process/no_descriptors.h"
#include "tests/unit/builder/built.h"
#include "tests/unit/daemon/fake_sink.h"

namespace hapticd::test {
namespace {

class MeshStoreTest : public ::testing::Test {
 protected:
  MeshStoreTest() { store_.setLock(false); }

  static UniqueFd built(const UploadMesh& mesh, std::uint32_t flags) {
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(mesh, flags), monitor);
    EXPECT_TRUE(snapshot.ok()) << toString(snapshot.error());
    return std::move(*snapshot->memfd.share());
  }
  /** More than 4 MiB. */
  static UniqueFd large() { return built(torus(240, 120), HD_MESH_DEFORMABLE); }
  static UniqueFd small() { return built(torus(12, 8), HD_MESH_DEFORMABLE); }

  std::uint64_t add(UniqueFd snapshot) {
    const auto id = store_.add(std::move(snapshot), {});
    EXPECT_TRUE(id.ok()) << toString(id.error());
    return *id;
  }
  [[nodiscard]] bool comesToBeReady() {
    return eventually([&] {
      store_.reclaim();
      return store_.readyForServo();
    });
  }
  [[nodiscard]] bool comesToRest() {
    return eventually([&] {
      store_.reclaim();
      return !store_.busy();
    });
  }
  [[nodiscard]] static const MeshView* first(FakeSink& sink) { return sink.meshes().get(0); }

  FakeSink one_, other_;
  MeshStore store_;
};

TEST_F(MeshStoreTest, WhatIsCheckedHoldsACopyForEachServoIfItIsDeformable) {
  ASSERT_TRUE(store_.attach(one_) && store_.attach(other_));
  EXPECT_EQ(checkMesh(built(torus(12, 8), 0), UniqueFd(), false, 2)->memory.size(), 1u);
  EXPECT_EQ(checkMesh(small(), UniqueFd(), false, 0)->memory.size(), 1u);
  auto checked = checkMesh(small(), UniqueFd(), false, store_.servos());
  ASSERT_TRUE(checked);
  ASSERT_EQ(checked->memory.size(), 2u);

  const NoDescriptors none;
  const auto id = store_.add(std::move(*checked), {});
  ASSERT_TRUE(id) << toString(id.error());
  ASSERT_TRUE(first(one_) != nullptr && first(other_) != nullptr);
  EXPECT_NE(first(one_)->vertices, first(other_)->vertices);
}

TEST_F(MeshStoreTest, ALargeOneIsCopiedForTheNextServoBeforeItComes) {
  ASSERT_TRUE(store_.attach(one_));
  add(large());
  EXPECT_FALSE(store_.readyForServo());
  ASSERT_TRUE(comesToBeReady());
  {
    const NoDescriptors none;
    const auto attached = store_.attach(other_);
    ASSERT_TRUE(attached) << toString(attached.error());
  }
  EXPECT_NE(first(one_)->vertices, first(other_)->vertices);
  EXPECT_FALSE(store_.readyForServo()) << "a third needs its own";
}

/** Memory that has been mapped of snapshots and of what moves. */
long mapped() {
  std::ifstream maps("/proc/self/maps");
  long count = 0;
  for (std::string line; std::getline(maps, line);) count += line.find("memfd:hapticd") != std::string::npos ? 1 : 0;
  return count;
}

TEST_F(MeshStoreTest, WhatWasMadeForAServoThatDoesNotComeGoes) {
  ASSERT_TRUE(store_.attach(one_));
  add(large());
  const long before = mapped();
  ASSERT_TRUE(comesToBeReady());
  ASSERT_GT(mapped(), before);
  store_.noServoComes();
  ASSERT_TRUE(comesToRest());
  EXPECT_EQ(mapped(), before);
  EXPECT_FALSE(store_.readyForServo()) << "the next needs its own";
  ASSERT_TRUE(comesToBeReady());
}

TEST_F(MeshStoreTest, ASmallOneNeedsNoPreparation) {
  ASSERT_TRUE(store_.attach(one_));
  add(small());
  EXPECT_TRUE(store_.readyForServo());
  EXPECT_FALSE(store_.busy());
  EXPECT_TRUE(store_.attach(other_));
  EXPECT_NE(first(one_)->vertices, first(other_)->vertices);
}

TEST_F(MeshStoreTest, WhereNoCopyCanBeMadeTheServoIsToldWhyAndTheNextMayTry) {
  ASSERT_TRUE(store_.attach(one_));
  add(large());
  {
    const NoDescriptors none;
    EXPECT_TRUE(store_.readyForServo());
    EXPECT_EQ(store_.attach(other_).error().code, ErrorCode::kSystem);
  }
  ASSERT_TRUE(comesToBeReady());
  EXPECT_TRUE(store_.attach(other_));
}

TEST_F(MeshStoreTest, OneThatIsDroppedWhileItIsCopiedKeepsNobodyWaiting) {
  ASSERT_TRUE(store_.attach(one_));
  const std::uint64_t id = add(large());
  EXPECT_FALSE(store_.readyForServo());
  ASSERT_TRUE(store_.drop(id, {}));
  EXPECT_TRUE(store_.readyForServo());
  EXPECT_TRUE(comesToRest());
  EXPECT_TRUE(store_.attach(other_));
  EXPECT_EQ(first(other_), nullptr);
}

TEST_F(MeshStoreTest, WhatIsLargeIsUnmappedAside) {
  ASSERT_TRUE(store_.attach(one_));
  ASSERT_TRUE(store_.drop(add(small()), {}));
  store_.reclaim();
  EXPECT_FALSE(store_.busy());

  ASSERT_TRUE(store_.drop(add(large()), {}));
  store_.reclaim();
  EXPECT_TRUE(store_.busy());
  EXPECT_EQ(first(one_), nullptr);
  EXPECT_TRUE(comesToRest());

  add(large());
  store_.detach(one_);
  EXPECT_TRUE(store_.busy());
  EXPECT_TRUE(comesToRest());
}

}  // namespace
}  // namespace hapticd::test

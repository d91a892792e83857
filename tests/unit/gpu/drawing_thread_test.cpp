// One thread draws for all callers; the meshes equal those of an extractor on the caller's own thread.
#include "gpu/drawing_thread.hpp"

#include <thread>

#include <tbb/task_arena.h>

#include "drawings.hpp"
#include "support/fields.hpp"

namespace isoextract::gpu {
namespace {

Result<DrawingThread> start_drawing() {
  GpuOptions options;
  options.keep_samples = true;
  options.debug = true;
  return DrawingThread::start(options);
}

extract::ExtractOptions half() {
  extract::ExtractOptions options = test::at_iso(500);
  options.edge_keys = true;
  return options;
}

TEST(DrawingThread, ServesSeveralThreads) {
  const auto drawing = start_drawing();
  ASSERT_TRUE(drawing) << drawing.error().message;
  constexpr int kThreads = 4;
  std::vector<field::ScalarField> fields;
  std::vector<mesh::Mesh> expected;
  for (int t = 0; t < kThreads; ++t) {
    fields.push_back(test::random_field<float>({18 + t, 17, 20}, static_cast<unsigned>(t), 1000));
    expected.push_back(test::extract_on_gpu(fields.back(), half()).mesh);
    test::expect_same_surface(test::extract(fields.back(), half()).mesh, expected.back());
  }
  std::vector<std::vector<Result<extract::Extraction>>> found(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] {
        const auto extractor = drawing->extractor();
        tbb::task_arena arena(1 + t % 2);
        for (int again = 0; again < 3; ++again) {
          arena.execute([&] { found[t].push_back(extractor->extract(fields[t], half(), Context())); });
        }
      });
    }
  }
  for (int t = 0; t < kThreads; ++t) {
    for (const auto& extraction : found[t]) {
      ASSERT_TRUE(extraction) << extraction.error().message;
      test::expect_same_bytes(expected[t], extraction->mesh);
    }
  }
}

TEST(DrawingThread, KeepsProgramsForItsExtractors) {
  auto drawing = start_drawing();
  ASSERT_TRUE(drawing) << drawing.error().message;
  const field::ScalarField field = test::random_field<float>({18, 17, 20}, 5, 1000);
  auto first = drawing->extractor();
  const auto second = drawing->extractor();
  EXPECT_EQ(first->name(), "gpu");
  EXPECT_EQ(first->device(), gl::describe(drawing->device()));
  EXPECT_TRUE(first->has(extract::Method::mc));
  ASSERT_TRUE(first->extract(field, half(), Context()));
  first.reset();
  drawing = tl::unexpected(Error{});  // destroys the handle; the thread stays, because an extractor still uses it
  const auto again = second->extract(field, half(), Context());
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->stats.device->samples_uploaded, 0U) << "one device for both";
}

TEST(DrawingThread, UsesContextOfCaller) {
  const auto drawing = start_drawing();
  ASSERT_TRUE(drawing) << drawing.error().message;
  const auto extractor = drawing->extractor();
  const field::ScalarField field = test::random_field<float>({18, 17, 20}, 5, 1000);
  const Context own;
  const auto made = extractor->extract(field, half(), own);
  ASSERT_TRUE(made);
  EXPECT_GE(own.memory().peak(), made->mesh.memory.bytes());
  const Context narrow{MemoryBudget(1000)};
  const auto failed = extractor->extract(field, half(), narrow);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  const Context over;
  over.cancel();
  const auto cancelled = extractor->extract(field, half(), over);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, ErrorCode::cancelled);
  const auto again = extractor->extract(field, half(), Context());
  ASSERT_TRUE(again) << again.error().message;
  test::expect_same_bytes(made->mesh, again->mesh);
}

TEST(DrawingThread, FailsWithoutDevice) {
  GpuOptions options;
  options.device = 99;
  const auto drawing = DrawingThread::start(options);
  ASSERT_FALSE(drawing);
  EXPECT_EQ(drawing.error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace isoextract::gpu

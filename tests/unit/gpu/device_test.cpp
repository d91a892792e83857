// Devices: how options choose one, and machines without drivers or with broken ones.
#include "gl/gpu_device.hpp"

#include <sys/wait.h>

#include <array>
#include <cstdio>

#include <gtest/gtest.h>

#include "gpu/gpu_extractor.hpp"
#include "support/fields.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::gpu {
namespace {

TEST(DeviceChoice, ParsesNumbersCudaNumbersAndNames) {
  EXPECT_EQ(std::get<int>(gl::parse_device_choice("0").value()), 0);
  EXPECT_EQ(std::get<int>(gl::parse_device_choice("12").value()), 12);
  EXPECT_EQ(std::get<gl::CudaIndex>(gl::parse_device_choice("cuda:3").value()).number, 3);
  EXPECT_EQ(std::get<gl::DeviceName>(gl::parse_device_choice("llvmpipe").value()).part, "llvmpipe");
  EXPECT_EQ(std::get<gl::DeviceName>(gl::parse_device_choice("4090 Ti").value()).part, "4090 Ti");
  for (const char* wrong : {"", "cuda:", "cuda:x", "cuda:-1", "cuda:1x"}) {
    const auto choice = gl::parse_device_choice(wrong);
    ASSERT_FALSE(choice) << wrong;
    EXPECT_EQ(choice.error().code, ErrorCode::usage);
    EXPECT_FALSE(choice.error().hint.empty());
  }
}

gl::GpuDevice device(int index, std::string renderer, bool software = false, std::optional<int> cuda = std::nullopt) {
  gl::GpuDevice made;
  made.index = index;
  made.vendor = software ? "Mesa" : "NVIDIA Corporation";
  made.renderer = std::move(renderer);
  made.software = software;
  made.cuda_index = cuda;
  return made;
}

gl::GpuDevice broken(int index) {
  gl::GpuDevice made;
  made.index = index;
  made.problem = Error{ErrorCode::unavailable, "the driver failed to initialize", "ask its maker"};
  return made;
}

int chosen(const std::vector<gl::GpuDevice>& devices, const gl::DeviceChoice& choice) {
  const auto found = gl::choose_device(devices, choice);
  return found ? found->index : -1;
}

TEST(DeviceChoice, PrefersHardware) {
  const std::vector devices{broken(0), device(1, "llvmpipe", true), device(2, "H100", false, 1),
                            device(3, "RTX 4090", false, 0)};
  EXPECT_EQ(chosen(devices, {}), 2);
  EXPECT_EQ(chosen({broken(0), device(1, "llvmpipe", true)}, {}), 1);
  EXPECT_EQ(chosen(devices, 1), 1);
  EXPECT_EQ(chosen(devices, gl::CudaIndex{0}), 3);
  EXPECT_EQ(chosen(devices, gl::CudaIndex{1}), 2);
  EXPECT_EQ(chosen(devices, gl::DeviceName{"nvidia"}), 2) << "the first of that name";
  EXPECT_EQ(chosen(devices, gl::DeviceName{"rtx"}), 3);
  EXPECT_EQ(chosen(devices, gl::DeviceName{"LLVM"}), 1);
}

TEST(DeviceChoice, ListsDevicesIfNoneFits) {
  const std::vector devices{device(0, "H100", false, 1), device(1, "llvmpipe", true), broken(2)};
  for (const gl::DeviceChoice& choice :
       {gl::DeviceChoice{7}, gl::DeviceChoice{gl::CudaIndex{0}}, gl::DeviceChoice{gl::DeviceName{"Radeon"}}}) {
    const auto found = gl::choose_device(devices, choice);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::unavailable);
    for (const char* part : {"0: H100 (cuda:1)", "1: llvmpipe", "2: not usable (the driver failed to initialize)"}) {
      EXPECT_NE(found.error().message.find(part), std::string::npos) << found.error().message;
    }
  }
  const auto own = gl::choose_device(devices, 2);
  ASSERT_FALSE(own);
  EXPECT_EQ(own.error().message, "the driver failed to initialize") << "why that device cannot be used";
}

TEST(Devices, FailWithListIfOutOfRange) {
  GpuOptions options;
  options.device = 99;
  const auto extractor = make_gpu_extractor(options);
  ASSERT_FALSE(extractor);
  EXPECT_EQ(extractor.error().code, ErrorCode::unavailable);
  EXPECT_NE(extractor.error().message.find("no device 99; the devices are 0: "), std::string::npos)
      << extractor.error().message;
  options.device = gl::DeviceName{"no such renderer"};
  EXPECT_FALSE(make_gpu_extractor(options));
}

TEST(Devices, AreListedAsOpened) {
  const auto devices = gl::list_gpu_devices();
  ASSERT_TRUE(devices) << devices.error().message;
  for (std::size_t d = 0; d < devices->size(); ++d) EXPECT_EQ((*devices)[d].index, static_cast<int>(d));
  const auto first = gl::choose_device(*devices, {});
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->version.empty());
  GpuOptions options;
  options.device = first->index;
  const auto extractor = make_gpu_extractor(options);
  ASSERT_TRUE(extractor);
  EXPECT_EQ(extractor->extractor->device(), gl::describe(*first));
}

// Each extractor draws in its own context, in any order of use and destruction.
TEST(Devices, ServeSeveralExtractors) {
  auto first = make_gpu_extractor({});
  auto second = make_gpu_extractor({});
  ASSERT_TRUE(first && second);
  const field::ScalarField field = test::random_field<float>({10, 10, 10}, 3, 100);
  extract::ExtractOptions options;
  options.iso = 50;
  const auto a = first->extractor->extract(field, options, Context());
  const auto b = second->extractor->extract(field, options, Context());
  const auto again = first->extractor->extract(field, options, Context());
  first->extractor.reset();
  const auto alone = second->extractor->extract(field, options, Context());
  for (const auto* extraction : {&a, &b, &again, &alone}) {
    ASSERT_TRUE(*extraction) << extraction->error().message;
    EXPECT_FALSE((*extraction)->mesh.triangles.empty());
    EXPECT_TRUE(std::ranges::equal((*extraction)->mesh.positions, a->mesh.positions));
  }
}

struct Answer {
  std::string text;
  int status = -1;
};

// Returns the output of the probe with `environment` ("NAME=value ...") set.
Answer probe(const std::string& environment) {
  Answer answer;
  const std::string command = "env " + environment + " '" ISOEXTRACT_DEVICE_PROBE "' 2>&1";
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return answer;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) answer.text += buffer.data();
  answer.status = ::pclose(pipe);
  return answer;
}

void expect_unavailable(const std::string& environment, std::initializer_list<const char*> parts) {
  const Answer answer = probe(environment);
  EXPECT_TRUE(WIFEXITED(answer.status) && WEXITSTATUS(answer.status) == 0) << answer.text;
  EXPECT_NE(answer.text.find("error 3|"), std::string::npos) << answer.text;  // ErrorCode::unavailable
  for (const char* part : parts) EXPECT_NE(answer.text.find(part), std::string::npos) << answer.text;
}

TEST(Drivers, AreInstalled) {
  const Answer answer = probe("X=1");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.text.find("drawing on "), 0U) << answer.text;
}

TEST(Drivers, FailIfNotInstalled) {
  expect_unavailable("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent/x.json", {"EGL", "use_cpu"});
}

TEST(Drivers, FailIfLibrariesAreBroken) {
  const test::TempFolder folder;
  const auto with_folder = [&] { return "LD_LIBRARY_PATH='" + folder.path().string() + "'"; };
  test::write_bytes(folder / "libEGL.so.1", "this is no library");
  expect_unavailable(with_folder(), {"EGL failed to load", "libEGL.so.1", "libegl1", "use_cpu"});
  test::write_bytes(folder / "libEGL.so.1", test::read_bytes(ISOEXTRACT_NO_FUNCTIONS));
  expect_unavailable(with_folder(), {"EGL failed to load", "eglGetProcAddress"});
  std::filesystem::remove(folder / "libEGL.so.1");
  test::write_bytes(folder / "libOpenGL.so.0", "neither is this");
  test::write_bytes(folder / "libGL.so.1", "nor this");
  expect_unavailable(with_folder(), {"OpenGL failed to load", "libopengl0"});
}

// The loader exists, but the driver that it names does not.
TEST(Drivers, FailIfVendorLibraryIsMissing) {
  const test::TempFolder folder;
  test::write_bytes(folder / "vendor.json",
                    R"({"file_format_version": "1.0.0", "ICD": {"library_path": "libEGL_nobody.so.0"}})");
  expect_unavailable("__EGL_VENDOR_LIBRARY_FILENAMES='" + (folder / "vendor.json").string() + "'", {"EGL", "use_cpu"});
}

// Mesa without its drivers has a device that cannot be initialized, or none.
TEST(Drivers, FailIfMesaHasNoDrivers) {
  const auto devices = gl::list_gpu_devices();
  ASSERT_TRUE(devices) << devices.error().message;
  if (!std::ranges::all_of(*devices, &gl::GpuDevice::software))
    GTEST_SKIP() << "another driver than Mesa's llvmpipe is here";
  expect_unavailable("LIBGL_DRIVERS_PATH=/nonexistent", {"EGL failed to initialize on the device", "use_cpu"});
}

}  // namespace
}  // namespace isoextract::gpu

// SPDX-License-Identifier: MIT
// Pairs of boxes by Bullet 3's OpenCL: its grid, then its separating axis kernel. All boxes
// must have one size.
//
//     still_bullet BOXES CELL DEVICE RUNS
//
// DEVICE is a part of the name of an OpenCL platform. The grid has 128 x 128 x 128 cells, of edge
// CELL. Prints for the grid and the kernel the least wall clock and processor time in ms, then
// the candidates and the pairs that collide.
#include <Bullet3Collision/NarrowPhaseCollision/shared/b3Collidable.h>
#include <Bullet3Collision/NarrowPhaseCollision/shared/b3ConvexPolyhedronData.h>
#include <Bullet3Collision/NarrowPhaseCollision/shared/b3RigidBodyData.h>
#include <Bullet3OpenCL/BroadphaseCollision/b3GpuGridBroadphase.h>
#include <Bullet3OpenCL/Initialize/b3OpenCLUtils.h>
#include <Bullet3OpenCL/NarrowphaseCollision/kernels/satKernels.h>
#include <Bullet3OpenCL/ParallelPrimitives/b3LauncherCL.h>

#include "boxes.h"

#include <cstring>
#include <vector>

namespace
{
struct Grid : b3GpuGridBroadphase {
    Grid(cl_context context, cl_device_id device, cl_command_queue queue, float cell)
        : b3GpuGridBroadphase(context, device, queue)
    {
        for (int k = 0; k < 3; ++k)
            m_paramsCPU.m_invCellSize[k] = 1 / cell;
        m_paramsGPU.copyFromHostPointer(&m_paramsCPU, 1);
    }
};

template <class T> struct Buffer {
    b3OpenCLArray<T> array;
    Buffer(cl_context context, cl_command_queue queue, const std::vector<T> &rows)
        : array(context, queue)
    {
        array.resize(rows.size());
        array.copyFromHostPointer(rows.data(), rows.size());
    }
    cl_mem get()
    {
        return array.getBufferCL();
    }
};

cl_device_id find_device(const char *name)
{
    cl_platform_id platforms[16];
    cl_uint n = 0;
    clGetPlatformIDs(16, platforms, &n);
    for (cl_uint i = 0; i < n; ++i) {
        char text[256] = "";
        cl_device_id device;
        clGetPlatformInfo(platforms[i], CL_PLATFORM_NAME, sizeof text, text, nullptr);
        if (strstr(text, name) &&
            clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 1, &device, nullptr) == CL_SUCCESS)
            return device;
    }
    need(0, "no OpenCL platform has that name");
    return nullptr;
}

// A box of these half extents, as a convex hull: three axes, six faces of four corners.
struct Hull {
    std::vector<b3ConvexPolyhedronData> shape{1};
    std::vector<b3Vector3> vertices, edges;
    std::vector<b3GpuFace> faces;
    std::vector<int> indices;
    explicit Hull(const float *half)
    {
        for (int i = 0; i < 8; ++i)
            vertices.push_back(b3MakeVector3(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1],
                                             i & 4 ? half[2] : -half[2]));
        for (int axis = 0; axis < 3; ++axis) {
            b3Vector3 e = b3MakeVector3(axis == 0, axis == 1, axis == 2);
            edges.push_back(e);
            for (int upper = 0; upper < 2; ++upper) {
                b3GpuFace face = {};
                face.m_plane = upper ? e : -e;
                face.m_plane.w = -half[axis];
                face.m_indexOffset = static_cast<int>(indices.size());
                face.m_numIndices = 4;
                faces.push_back(face);
                int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, at = upper << axis;
                const int corners[4] = {at, at | u, at | u | v, at | v};
                for (int i = 0; i < 4; ++i)
                    indices.push_back(corners[upper ? i : 3 - i]);
            }
        }
        shape[0] = b3ConvexPolyhedronData();
        shape[0].m_localCenter = b3MakeVector3(0, 0, 0);
        shape[0].m_numFaces = 6;
        shape[0].m_numVertices = 8;
        shape[0].m_numUniqueEdges = 3;
    }
};
} // namespace

int main(int argc, char **argv)
{
    need(argc == 5, "give BOXES CELL DEVICE RUNS");
    size_t n;
    auto *boxes = static_cast<box *>(read_rows(argv[1], sizeof(box), &n));
    int runs = atoi(argv[4]);
    need(b3OpenCLUtils::getNumPlatforms() > 0, "no OpenCL platform"); // loads the library
    cl_int err;
    cl_device_id device = find_device(argv[3]);
    cl_context context = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &err);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, &err);
    need(err == CL_SUCCESS, "no queue on the device");

    Grid grid(context, device, queue, static_cast<float>(atof(argv[2])));
    std::vector<b3RigidBodyData> bodies(n);
    for (size_t i = 0; i < n; ++i) {
        const box &b = boxes[i];
        float r[3];
        box_reach(&b, r);
        b3Vector3 c = b3MakeVector3(b.centre[0], b.centre[1], b.centre[2]);
        b3Vector3 reach = b3MakeVector3(r[0], r[1], r[2]);
        grid.createProxy(c - reach, c + reach, static_cast<int>(i), 1, 1);
        bodies[i] = b3RigidBodyData();
        bodies[i].m_pos = c;
        bodies[i].m_quat =
            b3Quaternion(b.rotation[0], b.rotation[1], b.rotation[2], b.rotation[3]).normalized();
        bodies[i].m_invMass = 1;
    }
    grid.writeAabbsToGpu();

    Hull hull(boxes[0].half);
    std::vector<b3Collidable> collidable(1);
    collidable[0].m_shapeType = 3; // a convex hull
    collidable[0].m_shapeIndex = 0;
    Buffer<b3RigidBodyData> body_buffer(context, queue, bodies);
    Buffer<b3Collidable> collidable_buffer(context, queue, collidable);
    Buffer<b3ConvexPolyhedronData> shape_buffer(context, queue, hull.shape);
    Buffer<b3Vector3> vertex_buffer(context, queue, hull.vertices);
    Buffer<b3Vector3> edge_buffer(context, queue, hull.edges);
    Buffer<b3GpuFace> face_buffer(context, queue, hull.faces);
    Buffer<int> index_buffer(context, queue, hull.indices);
    cl_program program = b3OpenCLUtils::compileCLProgramFromString(
        context, device, satKernelsCL, &err, "",
        "src/Bullet3OpenCL/NarrowphaseCollision/kernels/sat.cl", true);
    cl_kernel kernel = b3OpenCLUtils::compileCLKernelFromString(
        context, device, satKernelsCL, "findSeparatingAxisKernel", &err, program, "");
    need(kernel != nullptr, "Bullet's kernel does not compile");

    lap grid_least = {}, kernel_least = {};
    size_t most = 4 * n, candidates = 0, colliding = 0;
    b3OpenCLArray<b3Vector3> normals(context, queue);
    b3OpenCLArray<int> answers(context, queue);
    normals.resize(most);
    answers.resize(most);
    for (int run = 0; run <= runs; ++run) { // the first is not counted
        lap unused = {}, begun = lap_begin();
        grid.calculateOverlappingPairs(static_cast<int>(most));
        clFinish(queue);
        lap_end(begun, run ? &grid_least : &unused);
        candidates = static_cast<size_t>(grid.getNumOverlap());

        begun = lap_begin();
        b3LauncherCL launcher(queue, kernel, "findSeparatingAxisKernel");
        for (cl_mem buffer : {grid.getOverlappingPairBuffer(), body_buffer.get(),
                              collidable_buffer.get(), shape_buffer.get(), vertex_buffer.get(),
                              edge_buffer.get(), face_buffer.get(), index_buffer.get(),
                              grid.getAabbBufferWS(), normals.getBufferCL(), answers.getBufferCL()})
            launcher.setBuffer(buffer);
        launcher.setConst(static_cast<int>(candidates));
        launcher.launch1D(static_cast<int>(candidates));
        clFinish(queue);
        lap_end(begun, run ? &kernel_least : &unused);
    }
    std::vector<int> found(candidates);
    answers.copyToHostPointer(found.data(), candidates);
    for (int answer : found)
        colliding += answer == 1;
    printf("%.3f\t%.3f\t%.3f\t%.3f\t%zu\t%zu\n", grid_least.wall, grid_least.processor,
           kernel_least.wall, kernel_least.processor, candidates, colliding);
    fflush(nullptr);
    _Exit(0);
}

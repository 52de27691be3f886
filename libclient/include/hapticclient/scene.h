/** @file
 * The scene: named objects in a tree of rigid transforms, and the meshes they show. Shared by all clients.
 *
 * For changes at the pace of a simulation use the pushes of push.h; these functions go by the socket.
 */
#ifndef HAPTICCLIENT_SCENE_H
#define HAPTICCLIENT_SCENE_H

#include <hapticclient/client.h>
#include <hapticclient/effect.h>
#include <hapticclient/texture.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum haptic_shape_kind {
  HAPTIC_SHAPE_GROUP = 0,    /**< Nothing to touch; a parent for others. */
  HAPTIC_SHAPE_PLANE = 1,    /**< Solid below z = 0; outward normal +z. */
  HAPTIC_SHAPE_SPHERE = 2,   /**< size[0]: radius. */
  HAPTIC_SHAPE_BOX = 3,      /**< size: half-extents. */
  HAPTIC_SHAPE_CAPSULE = 4,  /**< size[0]: radius, size[1]: half-length along z without the caps. */
  HAPTIC_SHAPE_CYLINDER = 5, /**< size[0]: radius, size[1]: half-length along z. */
  HAPTIC_SHAPE_MESH = 6      /**< mesh: id from an upload. */
} haptic_shape_kind;

typedef struct haptic_shape {
  uint32_t kind; /**< haptic_shape_kind */
  uint32_t reserved;
  double size[3]; /**< [m] */
  uint64_t mesh;
} haptic_shape;

/** Bits of haptic_object.flags; the first three are those of haptic_object_flags in push.h. */
typedef enum haptic_object_flag {
  HAPTIC_OBJECT_ENABLED = 1 << 0,   /**< It can be touched. */
  HAPTIC_OBJECT_VISIBLE = 1 << 1,   /**< For viewers. */
  HAPTIC_OBJECT_TWO_SIDED = 1 << 2, /**< Both faces of an open mesh stop the proxy. */
  HAPTIC_OBJECT_KEEP = 1 << 8       /**< It stays when the client that made it leaves. */
} haptic_object_flag;

/** An object as you ask for it. */
typedef struct haptic_object {
  uint32_t size;
  uint32_t flags;     /**< haptic_object_flag */
  const char* name;   /**< Unique; letters, digits, '_', '.', '-'; at most 63 bytes. */
  const char* parent; /**< Name of the parent; null or "": the root. */
  haptic_pose pose;   /**< In the parent's frame. */
  haptic_shape shape;
  haptic_material material;
} haptic_object;

/** Enabled, visible, at the origin; no name and no shape yet; 1000 N/m, 1 N s/m, no friction. */
#define HAPTIC_OBJECT_INIT                                                                                       \
  {                                                                                                              \
    sizeof(haptic_object), HAPTIC_OBJECT_ENABLED | HAPTIC_OBJECT_VISIBLE, NULL, NULL, {{0, 0, 0}, {1, 0, 0, 0}}, \
        {HAPTIC_SHAPE_GROUP, 0, {0, 0, 0}, 0}, {                                                                 \
      1000, 1, 0, 0                                                                                              \
    }                                                                                                            \
  }

/** An object as it stands. */
typedef struct haptic_object_state {
  uint32_t size;
  uint32_t id; /**< For pushes. */
  uint32_t triangles;
  uint32_t reserved;
  const char* path; /**< /_objects/A/B/C */
  const char* owner;
  haptic_pose world_pose;
  const haptic_object* object;
  const haptic_surface* surface;
} haptic_object_state;

typedef struct haptic_object_list {
  uint32_t size;
  uint32_t count;
  const haptic_object_state* const* items;
} haptic_object_list;

/** Creates an object. `id`, if not null, receives its number for pushes. Blocks; any thread, as all here. */
HAPTIC_API int haptic_object_create(haptic_client* client, const haptic_object* object, uint32_t* id,
                                    haptic_error* error);
/** Removes an object with its children. */
HAPTIC_API int haptic_object_remove(haptic_client* client, const char* name, haptic_error* error);
HAPTIC_API int haptic_object_list_all(haptic_client* client, haptic_object_list** objects, haptic_error* error);
HAPTIC_API int haptic_object_find(haptic_client* client, const char* name, haptic_object_state** state,
                                  haptic_error* error);
/** HAPTIC_WOULD_BLOCK while it is the tool in a hand. */
HAPTIC_API int haptic_object_set_pose(haptic_client* client, const char* name, const haptic_pose* pose,
                                      haptic_error* error);
HAPTIC_API int haptic_object_set_material(haptic_client* client, const char* name, const haptic_material* material,
                                          haptic_error* error);
/** `flags`: all of enabled, visible and two-sided as they shall be. Whether it is kept stays as when it was made. */
HAPTIC_API int haptic_object_set_flags(haptic_client* client, const char* name, uint32_t flags, haptic_error* error);
HAPTIC_API int haptic_object_set_shape(haptic_client* client, const char* name, const haptic_shape* shape,
                                       haptic_error* error);

/** What the builder made of a mesh. */
typedef struct haptic_mesh_report {
  uint32_t size;
  uint32_t closed; /**< 1: it has an inside. */
  uint64_t id;     /**< For haptic_shape.mesh. */
  uint32_t vertices;
  uint32_t triangles;
  uint64_t bytes;
  double lower[3]; /**< Bounding box [m]. */
  double upper[3];
  int64_t build_ns;
  uint32_t note_count;
  uint32_t reserved;
  const char* const* notes; /**< Repairs, each naming its triangle. */
} haptic_mesh_report;

typedef struct haptic_mesh_list {
  uint32_t size;
  uint32_t count;
  const haptic_mesh_report* const* items;
} haptic_mesh_list;

/** A mesh being filled: a piece of the daemon's memory. One thread at a time. */
typedef struct haptic_upload haptic_upload;

/** Bits of the mesh flags. */
typedef enum haptic_mesh_flag {
  HAPTIC_MESH_DEFORMABLE = 1 << 1, /**< Its vertices can be moved by pushes. */
  HAPTIC_MESH_VOLUME = 1 << 2,     /**< The solid as a volume too, for what touches in six degrees of freedom. */
  HAPTIC_MESH_FILL_HOLES = 1 << 3  /**< With it: holes are closed for the volume; else an open mesh is refused. */
} haptic_mesh_flag;

/**
 * Called on the thread that commits, `fraction` from 0 to 1; a few times a second with the same where nothing new is
 * told, which at the beginning is 0 and "waiting". Return 0 to go on, else to cancel (HAPTIC_CANCELLED).
 */
typedef int (*haptic_progress)(float fraction, const char* stage, void* user);

/**
 * Begins a mesh of so many vertices and triangles. Fill haptic_upload_vertices() (x, y, z floats in metres) and
 * haptic_upload_triangles() (three vertex indices each, counter-clockwise seen from outside), then commit. Blocks.
 */
HAPTIC_API int haptic_upload_begin(haptic_client* client, uint32_t vertices, uint32_t triangles, uint32_t flags,
                                   haptic_upload** upload, haptic_error* error);
/** The arrays to fill; null once committed. */
HAPTIC_API float* haptic_upload_vertices(haptic_upload* upload);
HAPTIC_API uint32_t* haptic_upload_triangles(haptic_upload* upload);

/**
 * Vertices no farther apart than `distance_m` (1 um to 10 mm) become one: for scans and exports whose seams do not
 * quite meet. Without it only equal ones do. Before the commit.
 */
HAPTIC_API int haptic_upload_weld(haptic_upload* upload, double distance_m, haptic_error* error);

/**
 * How the volume of a mesh begun with HAPTIC_MESH_VOLUME shall be: the side of its voxels (1 um to 1 m), and the
 * distance of its surface points (0: a voxel). Needed before the commit. The mesh must be closed, or begun
 * with HAPTIC_MESH_FILL_HOLES. It is refused with the memory it would take if that is too much. Building takes seconds:
 * see the progress.
 */
HAPTIC_API int haptic_upload_volume(haptic_upload* upload, double voxel_m, double point_spacing_m, haptic_error* error);

/**
 * Unmaps the arrays and has the mesh built. Waits for the builder as long as it takes, at most `timeout_ns` (0: 10
 * minutes). HAPTIC_STILL_MAPPED: you mapped it elsewhere; unmap and commit again. HAPTIC_BAD_MESH names the triangle.
 * After HAPTIC_CANCELLED or HAPTIC_TIMEOUT the upload is over, and so is one whose daemon was lost
 * (HAPTIC_DISCONNECTED): its arrays stay, to be uploaded again, if that was before the commit.
 */
HAPTIC_API int haptic_upload_commit(haptic_upload* upload, haptic_progress progress, void* user, int64_t timeout_ns,
                                    haptic_mesh_report** report, haptic_error* error);
/** Frees the handle; an upload that was not committed is cancelled. Null is allowed. */
HAPTIC_API void haptic_upload_close(haptic_upload* upload);

/** Begin, copy, commit and close in one call. */
HAPTIC_API int haptic_upload_mesh(haptic_client* client, const float* vertices, uint32_t vertex_count,
                                  const uint32_t* triangles, uint32_t triangle_count, uint32_t flags,
                                  haptic_progress progress, void* user, haptic_mesh_report** report,
                                  haptic_error* error);
/** All meshes, whoever uploaded them. */
HAPTIC_API int haptic_mesh_list_all(haptic_client* client, haptic_mesh_list** meshes, haptic_error* error);
/**
 * The volume of an object's mesh as an OpenVDB file: a descriptor to read, which the caller closes. For the user who
 * uploaded the mesh, or on an administration connection. HAPTIC_WOULD_BLOCK: it is being made, some seconds after the
 * volume; HAPTIC_UNSUPPORTED: the daemon makes none; HAPTIC_NOT_FOUND: there is none.
 */
HAPTIC_API int haptic_object_volume_file(haptic_client* client, const char* name, int* fd, haptic_error* error);
/** Gives a mesh back; refused while an object shows it. It goes by itself with the client that made it, once unused. */
HAPTIC_API int haptic_mesh_drop(haptic_client* client, uint64_t mesh, haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_SCENE_H */

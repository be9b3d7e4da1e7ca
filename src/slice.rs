//! Sections from meshes: a closed mesh cut by planes.

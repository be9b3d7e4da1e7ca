//! What a shader's source says, held against what the host takes for granted; needs no GPU.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Literal, Module};

use super::STORAGE_BUFFERS;

/// A shader that is valid.
pub struct Shader {
    module: Module,
    info: ModuleInfo,
}

impl Shader {
    /// Panics where it is not.
    pub fn new(source: &str) -> Self {
        let module = naga::front::wgsl::parse_str(source)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
        let shader = Self { module, info };
        let most = shader.storage_buffers();
        assert!(most <= STORAGE_BUFFERS as usize, "{most} storage buffers are bound");
        shader
    }

    /// How large its structures are, in bytes.
    pub fn require_sizes(&self, sizes: &[(&str, usize)]) {
        let context = self.module.to_ctx();
        for &(name, size) in sizes {
            let named = |kind: &naga::Type| kind.name.as_deref() == Some(name);
            let (_, found) = self.module.types.iter().find(|(_, kind)| named(kind)).unwrap();
            assert_eq!(found.inner.size(context) as usize, size, "{name}");
        }
    }

    /// The value of a constant.
    pub fn constant(&self, name: &str) -> usize {
        let named = |constant: &naga::Constant| constant.name.as_deref() == Some(name);
        let (_, found) = self.module.constants.iter().find(|(_, own)| named(own)).unwrap();
        match self.module.global_expressions[found.init] {
            naga::Expression::Literal(Literal::U32(value)) => value as usize,
            ref other => panic!("{name}: {other:?}"),
        }
    }

    /// The invocations in a workgroup of each entry point.
    pub fn workgroups(&self) -> Vec<u32> {
        self.module.entry_points.iter().map(|entry| entry.workgroup_size.iter().product()).collect()
    }

    /// How many storage buffers an entry point uses, at most.
    fn storage_buffers(&self) -> usize {
        let is_storage = |space| matches!(space, AddressSpace::Storage { .. });
        let used = |entry: usize| {
            let own = self.info.get_entry_point(entry);
            let globals = self.module.global_variables.iter();
            globals.filter(|&(at, one)| is_storage(one.space) && !own[at].is_empty()).count()
        };
        (0..self.module.entry_points.len()).map(used).max().unwrap_or(0)
    }
}

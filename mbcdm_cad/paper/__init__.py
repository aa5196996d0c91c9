"""The paper that defines the mechanism: its figures compared with the model's, its experiments on the dynamic rig."""
